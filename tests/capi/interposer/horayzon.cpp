// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Uses Embree 4 as HORAYZON does, a program that computes horizons and shadows of terrain: a raster of heights is one
 * grid, or quads, or triangles, next to a coarse mesh of the surroundings, in a robust scene. Single rays start close
 * to the terrain. A first run without the interposer stores horizons and hits in a file; a second run with it must have
 * the same, see hits.h. Depends only on the parts of host.h for Embree.
 *
 *   horayzon FILE [traversables]     writes FILE if it does not exist, otherwise compares with it. `traversables`:
 *                                    queries traversables instead of scenes */

#include "../host.h"
#include "hits.h"
#include "scene_queries.h"

using host::Vec;
using stored_hits::Hits;

namespace {

constexpr unsigned rows = 160, columns = 230; // 36411 quads, which interposer.sh finds in the log
constexpr float spacing = 30;                 // in meters, as are all lengths
constexpr float eyeLevel = 0.1f, farthest = 20000;
constexpr float degree = 0.01745329f;

float heightAt(float x, float y) {
  return 1500 + 700 * std::sin(x / 900) * std::cos(y / 700 + x / 2500) + 60 * std::sin(x / 110 + y / 170) +
         9 * std::sin(x / 41 - y / 37);
}

struct Corners3 {
  unsigned v[3];
};
struct Corners4 {
  unsigned v[4];
};

class Terrain {
public:
  /* stride: floats per vertex. The last vertex is padded to 16 bytes, which Embree reads. */
  explicit Terrain(size_t stride) : stride(stride), vertices(rows * columns * stride + 4) {
    for (unsigned i = 0; i < rows; i++)
      for (unsigned j = 0; j < columns; j++) {
        const float x = spacing * float(j), y = spacing * float(i);
        const Vec point = {x, y, heightAt(x, y)};
        std::copy(point.begin(), point.end(), &vertices[(i * columns + j) * stride]);
      }
  }

  /* Returns a committed geometry with the mask that Embree 4 gives it, which is 1. */
  RTCGeometry newGeometry(RTCDevice device, RTCGeometryType type) const {
    const RTCGeometry geometry = rtcNewGeometry(device, type);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.data(), 0,
                               stride * sizeof(float), rows * columns);
    if (type == RTC_GEOMETRY_TYPE_GRID) setGrid(geometry);
    else if (type == RTC_GEOMETRY_TYPE_QUAD) setQuads(geometry);
    else setTriangles(geometry);
    rtcCommitGeometry(geometry);
    return geometry;
  }

private:
  static void setGrid(RTCGeometry geometry) {
    RTCGrid* const grid =
        (RTCGrid*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), 1);
    *grid = {0, columns, columns, rows};
  }

  static void setQuads(RTCGeometry geometry) {
    Corners4* quad = (Corners4*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                                        sizeof(Corners4), (rows - 1) * (columns - 1));
    forEachQuad([&](unsigned a, unsigned b, unsigned c, unsigned d) { *quad++ = {{a, b, d, c}}; });
  }

  static void setTriangles(RTCGeometry geometry) {
    Corners3* triangle = (Corners3*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                            sizeof(Corners3), (rows - 1) * (columns - 1) * 2);
    forEachQuad([&](unsigned a, unsigned b, unsigned c, unsigned d) {
      *triangle++ = {{a, b, c}};
      *triangle++ = {{b, d, c}};
    });
  }

  template<typename Function>
  static void forEachQuad(const Function& function) {
    for (unsigned i = 0; i + 1 < rows; i++)
      for (unsigned j = 0; j + 1 < columns; j++) {
        const unsigned a = i * columns + j;
        function(a, a + 1, a + columns, a + columns + 1);
      }
  }

  const size_t stride;
  std::vector<float> vertices;
};

/* The ground around the terrain. */
class Surroundings {
public:
  RTCGeometry newGeometry(RTCDevice device) const {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0, 12, 4);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles, 0, 12, 2);
    rtcCommitGeometry(geometry);
    return geometry;
  }

private:
  const float vertices[13] = {-9e3f, -9e3f, 700, 16e3f, -9e3f, 700, -9e3f, 14e3f, 700, 16e3f, 14e3f, 700, 0};
  const Corners3 triangles[2] = {{{0, 1, 2}}, {{1, 3, 2}}};
};

class Program {
public:
  Program(RTCDevice device, Hits& hits) : device(device), hits(hits) {}

  void run() {
    const Terrain packed(3), padded(4);
    const std::pair<const char*, RTCGeometryType> forms[] = {
        {"grid", RTC_GEOMETRY_TYPE_GRID}, {"quads", RTC_GEOMETRY_TYPE_QUAD}, {"triangles", RTC_GEOMETRY_TYPE_TRIANGLE}};
    for (const auto& form : forms)
      for (const Terrain* terrain : {&packed, &padded}) {
        hits.begin(form.first);
        useTerrain(terrain->newGeometry(device, form.second));
        CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
      }
  }

private:
  void useTerrain(RTCGeometry geometry) {
    const RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    CHECK(rtcAttachGeometry(scene, geometry) == 0);
    const RTCGeometry around = surroundings.newGeometry(device);
    CHECK(rtcAttachGeometry(scene, around) == 1);
    rtcReleaseGeometry(around);
    rtcCommitScene(scene);
    for (const RTCRayQueryFlags flags : {RTC_RAY_QUERY_FLAG_INCOHERENT, RTC_RAY_QUERY_FLAG_COHERENT}) {
      setFlags(flags);
      horizons(scene);
      shadows(scene, ~0u);
    }
    for (const unsigned mask : {1u, 0u, 2u}) { // the mask of the terrain
      rtcSetGeometryMask(geometry, mask);
      rtcCommitGeometry(geometry);
      rtcCommitScene(scene);
      for (const unsigned ofRay : {0u, 1u, 3u}) shadows(scene, ofRay);
    }
    rtcReleaseGeometry(geometry);
    rtcReleaseScene(scene);
  }

  void setFlags(RTCRayQueryFlags flags) {
    rtcInitIntersectArguments(&intersect);
    rtcInitOccludedArguments(&occluded);
    intersect.flags = occluded.flags = flags;
  }

  /* Calls the function with places on the terrain. */
  template<typename Function>
  static void forEachPlace(unsigned step, const Function& function) {
    for (unsigned i = 5; i < rows; i += step)
      for (unsigned j = 7; j < columns; j += step) {
        const float x = spacing * float(j), y = spacing * float(i);
        function(Vec{x, y, heightAt(x, y) + eyeLevel});
      }
  }

  /* A ray at an elevation angle, in degrees, with the mask that HORAYZON relies on. */
  static RTCRayHit rayAt(const Vec& place, float azimuth, float angle) {
    const float level = std::cos(angle * degree);
    RTCRayHit ray =
        host::makeRay(place, {level * std::sin(azimuth), level * std::cos(azimuth), std::sin(angle * degree)});
    ray.ray.tfar = farthest;
    ray.ray.mask = 1;
    return ray;
  }

  /* Finds the elevation angle of each horizon by bisection, and the distance of the terrain five degrees below it. */
  void horizons(RTCScene scene) {
    forEachPlace(23, [&](const Vec& place) {
      for (int k = 0; k < 24; k++) {
        const float azimuth = 6.2831853f * float(k) / 24 + 0.01f; // not along edges, where two faces are right
        float low = -20, high = 89;
        while (high - low > 0.25f) {
          const float angle = (low + high) / 2;
          RTCRay ray = rayAt(place, azimuth, angle).ray;
          scene_queries::occluded(scene, &ray, &occluded);
          (ray.tfar < 0 ? low : high) = angle;
        }
        RTCRayHit horizon = rayAt(place, azimuth, low), below = rayAt(place, azimuth, low - 5);
        horizon.ray.tfar = INFINITY;
        horizon.hit.geomID = horizon.hit.primID = 0;
        horizon.hit.u = low / 100; // a difference of less than a degree is within the tolerance of hits
        hits.keep(horizon);
        scene_queries::intersect(scene, &below, &intersect);
        hits.keep(below);
      }
    });
  }

  void shadows(RTCScene scene, unsigned mask) {
    const float toSun[3] = {0.8f, 0.5f, 0.25f};
    forEachPlace(9, [&](const Vec& place) {
      RTCRayHit ray = host::makeRay(place, {toSun[0], toSun[1], toSun[2]});
      ray.ray.mask = mask;
      RTCRay shadow = ray.ray;
      scene_queries::occluded(scene, &shadow, &occluded);
      hits.keep(shadow);
      RTCRayHit down = host::makeRay({place[0] + 11, place[1] + 5, 4000}, {0, 0, -1});
      down.ray.mask = mask;
      scene_queries::intersect(scene, &down, &intersect);
      hits.keep(down);
    });
  }

  const RTCDevice device;
  Hits& hits;
  const Surroundings surroundings;
  RTCIntersectArguments intersect;
  RTCOccludedArguments occluded;
};

} // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return 2;
  scene_queries::useTraversables = argc == 3;
  if (scene_queries::useTraversables && !scene_queries::haveTraversables) return 2;
  Hits hits(argv[1]);
  const RTCDevice device = rtcNewDevice(nullptr);
  Program(device, hits).run();
  hits.conclude();
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  rtcReleaseDevice(device);
  return host::conclude("terrain as in HORAYZON");
}
