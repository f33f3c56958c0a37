// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Searches of Embree 4 for the closest point: the program's function computes the distance of the primitive with the
 * program's own vertices, and decreases the radius. Triangles, quads and grids, also in instances; single queries and
 * packets; functions of the query and of geometries. The distances must be those of all triangles. Depends only on the
 * parts of host.h for Embree.
 *
 *   nearest [traversables] */

#include "../host.h"
#include "scene_queries.h"

#include <limits>
#include <string>

namespace {

using host::Vec;

constexpr unsigned side = 61; // vertices of a sheet
constexpr float infinity = std::numeric_limits<float>::infinity();

Vec add(const Vec& a, double t, const Vec& b) {
  return {float(a[0] + t * b[0]), float(a[1] + t * b[1]), float(a[2] + t * b[2])};
}
double dot(const Vec& a, const Vec& b) { return double(a[0]) * b[0] + double(a[1]) * b[1] + double(a[2]) * b[2]; }

/* By repeated projection to the regions of Ericson, Real-Time Collision Detection, section 5.1.5. */
double distanceToTriangle(const Vec& p, const Vec& a, const Vec& b, const Vec& c) {
  const Vec ab = add(b, -1, a), ac = add(c, -1, a), ap = add(p, -1, a), bp = add(p, -1, b), cp = add(p, -1, c);
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp), va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  auto to = [&](const Vec& q) {
    const Vec d = add(p, -1, q);
    return std::sqrt(dot(d, d));
  };
  if (d1 <= 0 && d2 <= 0) return to(a);
  if (d3 >= 0 && d4 <= d3) return to(b);
  if (d6 >= 0 && d5 <= d6) return to(c);
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return to(add(a, d1 / (d1 - d3), ab));
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return to(add(a, d2 / (d2 - d6), ac));
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return to(add(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), add(c, -1, b)));
  return to(add(add(a, vb / (va + vb + vc), ab), vc / (va + vb + vc), ac));
}

enum Type { Triangles, Quads, Grid };

/* A sheet of side x side vertices above or below z = 0. */
struct Sheet {
  Type type;
  std::vector<Vec> vertices; // padded
  std::vector<unsigned> indices;
  RTCGrid grid = {0, side, side, side};

  Sheet(Type type, float z) : type(type) {
    for (unsigned y = 0; y < side; y++)
      for (unsigned x = 0; x < side; x++) {
        const double u = 4.0 * x / (side - 1) - 2, v = 4.0 * y / (side - 1) - 2;
        vertices.push_back({float(u), float(v), float(z + 0.3 * std::sin(3 * u + z) * std::cos(2 * v))});
      }
    vertices.push_back({0, 0, 0});
    for (unsigned y = 0; y + 1 < side; y++)
      for (unsigned x = 0; x + 1 < side; x++) {
        const unsigned a = y * side + x, b = a + 1, c = a + side + 1, d = a + side;
        if (type == Triangles) indices.insert(indices.end(), {a, b, d, c, d, b});
        if (type == Quads) indices.insert(indices.end(), {a, b, c, d});
      }
  }

  unsigned size() const { return type == Grid ? 1 : unsigned(indices.size() / (type == Triangles ? 3 : 4)); }

  double distance(const Vec& p, unsigned primID, const float* instance) const {
    auto vertex = [&](unsigned i) {
      const Vec& v = vertices[i];
      if (!instance) return v;
      Vec out;
      for (unsigned k = 0; k < 3; k++)
        out[k] = instance[k] * v[0] + instance[4 + k] * v[1] + instance[8 + k] * v[2] + instance[12 + k];
      return out;
    };
    auto quad = [&](unsigned a, unsigned b, unsigned c, unsigned d) {
      const Vec va = vertex(a), vb = vertex(b), vc = vertex(c), vd = vertex(d);
      return std::min(distanceToTriangle(p, va, vb, vd), distanceToTriangle(p, vc, vd, vb));
    };
    if (type == Triangles) {
      const unsigned* const i = &indices[3 * primID];
      return distanceToTriangle(p, vertex(i[0]), vertex(i[1]), vertex(i[2]));
    }
    if (type == Quads) {
      const unsigned* const i = &indices[4 * primID];
      return quad(i[0], i[1], i[2], i[3]);
    }
    double least = infinity;
    for (unsigned y = 0; y + 1 < side; y++)
      for (unsigned x = 0; x + 1 < side; x++) {
        const unsigned a = y * side + x;
        least = std::min(least, quad(a, a + 1, a + side + 1, a + side));
      }
    return least;
  }

  RTCGeometry newGeometry(RTCDevice device) const {
    const RTCGeometry geometry = rtcNewGeometry(device, type == Triangles ? RTC_GEOMETRY_TYPE_TRIANGLE
                                                        : type == Quads   ? RTC_GEOMETRY_TYPE_QUAD
                                                                          : RTC_GEOMETRY_TYPE_GRID);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.data(), 0, 12,
                               side * side);
    if (type == Grid)
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, &grid, 0, sizeof(grid), 1);
    else
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                 type == Quads ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3, indices.data(), 0,
                                 type == Quads ? 16 : 12, size());
    return geometry;
  }
};

const Sheet sheets[] = {{Triangles, 0}, {Quads, 1}, {Grid, -1}};

/* Of instances: rotated and moved; scaled differently along the axes. */
constexpr float rotated[16] = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 6, 1, 0, 1};
constexpr float scaled[16] = {0.5f, 0, 0.2f, 0, 0, 2, 0, 0, 0, 0.1f, 1.5f, 0, -5, 0, 2, 1};
constexpr const float* instances[] = {nullptr, rotated, scaled};

struct Search {
  Vec p;
  double nearest = infinity;
};

/* A function of a query or of a geometry. */
bool decreaseRadius(RTCPointQueryFunctionArguments* args) {
  Search& search = *(Search*)args->userPtr;
  const RTCPointQueryContext& context = *args->context;
  const float* const instance = context.instStackSize > 0 ? context.inst2world[context.instStackSize - 1] : nullptr;
  const double distance = sheets[args->geomID].distance(search.p, args->primID, instance);
  if (!(distance < search.nearest)) return false;
  search.nearest = distance;
  if (!(distance < args->query->radius)) return false;
  args->query->radius = float(distance);
  return true;
}

/* The three sheets. hasFunctions: with functions of geometries. */
RTCScene newScene(RTCDevice device, bool hasFunctions) {
  const RTCScene scene = rtcNewScene(device);
  for (const Sheet& sheet : sheets) {
    const RTCGeometry geometry = sheet.newGeometry(device);
    if (hasFunctions) rtcSetGeometryPointQueryFunction(geometry, decreaseRadius);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene);
  return scene;
}

RTCScene newSceneOfInstances(RTCDevice device, RTCScene inner) {
  const RTCScene scene = rtcNewScene(device);
  for (const float* const instance : {rotated, scaled}) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, inner);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, instance);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene);
  return scene;
}

double leastDistance(const Vec& p, bool isInstanced) {
  double least = infinity;
  for (const float* const instance : instances)
    if ((instance != nullptr) == isInstanced)
      for (const Sheet& sheet : sheets)
        for (unsigned i = 0; i < sheet.size(); i++) least = std::min(least, sheet.distance(p, i, instance));
  return least;
}

void expectNear(double found, double expected, const char* what) {
  if (std::fabs(found - expected) <= 2e-5 * (1 + expected)) return;
  if (host::failures++ < 20) std::fprintf(stderr, "%s: distance %g, expected %g\n", what, found, expected);
}

void test(RTCScene scene, bool isInstanced, bool hasFunctions) {
  std::mt19937 generator(17);
  std::uniform_real_distribution<float> place(-3, 3);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  for (int round = 0; round < 12; round++) {
    Search searches[4];
    RTCPointQuery4 packet;
    alignas(16) const int valid[4] = {-1, -1, -1, -1};
    void* userPtrs[4];
    double expected[4];
    for (unsigned i = 0; i < 4; i++) {
      const Vec p = {place(generator) + (isInstanced ? (i % 2 ? 5.0f : -5.0f) : 0), place(generator), place(generator)};
      expected[i] = leastDistance(p, isInstanced);
      for (const float factor : {infinity, 1.01f, 0.9f}) {
        Search search = {p};
        const float radius = factor * float(expected[i]);
        RTCPointQuery query = {p[0], p[1], p[2], 0, radius};
        scene_queries::pointQuery(scene, &query, &context, hasFunctions ? nullptr : decreaseRadius, &search);
        if (factor > 1) {
          expectNear(search.nearest, expected[i], hasFunctions ? "functions of geometries" : "single query");
          expectNear(query.radius, expected[i], "radius");
        } else CHECK(query.radius == radius);
      }
      searches[i].p = p;
      packet.x[i] = p[0];
      packet.y[i] = p[1];
      packet.z[i] = p[2];
      packet.time[i] = 0;
      packet.radius[i] = infinity;
      userPtrs[i] = &searches[i];
    }
    scene_queries::pointQuery(valid, scene, &packet, &context, hasFunctions ? nullptr : decreaseRadius, userPtrs);
    for (unsigned i = 0; i < 4; i++) expectNear(searches[i].nearest, expected[i], "packet");
  }
}

} // namespace

int main(int argc, char** argv) {
  scene_queries::useTraversables = argc > 1 && std::string(argv[1]) == "traversables";
  if (scene_queries::useTraversables && !scene_queries::haveTraversables) return 2;
  const RTCDevice device = rtcNewDevice("threads=2");
  for (const bool hasFunctions : {false, true}) {
    const RTCScene scene = newScene(device, hasFunctions), outer = newSceneOfInstances(device, scene);
    test(scene, false, hasFunctions);
    test(outer, true, hasFunctions);
    rtcReleaseScene(outer);
    rtcReleaseScene(scene);
  }
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  rtcReleaseDevice(device);
  return host::conclude("searches for closest points");
}
