// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays through the user geometry of a foreign Embree have libembree_cbvh's hits to the bit, with the application's IDs.
 * Hits of lossless surfaces match the foreign Embree's own kernels. */

#include "host.h"

#include <algorithm>
#include <string>

using namespace host;

namespace {

std::mt19937 generator(32);

void checkHit(CbvhGroup group, const RTCRayHit& ray, const RTCRayHit& found, unsigned geomID, unsigned instID) {
  CbvhRayHit own;
  std::memcpy(&own, &ray, sizeof(own));
  const bool isMet = cbvhIntersect1(group, &own, nullptr) != 0;
  CHECK(isMet == isHit(found));
  CHECK(std::memcmp(&own.ray, &found.ray, sizeof(own.ray)) == 0);
  if (!isMet || !isHit(found)) return;
  CHECK(std::memcmp(&own.hit, &found.hit, 5 * sizeof(float)) == 0);
  CHECK(found.hit.geomID == geomID);
  CHECK(found.hit.instID[0] == instID);
  size_t surface = 1000;
  unsigned primID = 0;
  CHECK(cbvhFindGroupPrimitive(group, found.hit.primID, &surface, &primID));
  CHECK(surface == own.hit.geomID);
  CHECK(primID == own.hit.primID);
}

bool isAnyHit(RTCScene scene, const RTCRay& ray, const Query& query = {}) {
  RTCRay any = ray;
  occluded(scene, any, query);
  return any.tfar < 0;
}

// isNative: the host supports packets of N. Otherwise Embree 3 also traces their inactive lanes.
template<unsigned N>
void checkPackets(CbvhGroup group, RTCScene scene, const std::vector<RTCRayHit>& rays, bool isCoherent,
                  bool isNative = true) {
  std::uniform_int_distribution<int> some(0, 3);
  for (size_t first = 0; first + N <= rays.size(); first += N) {
    typename Packet<N>::RayHits packet;
    typename Packet<N>::Rays any;
    alignas(64) int valid[N];
    const bool isSparse = isNative && first / N % 4 == 3;
    for (unsigned i = 0; i < N; i++) {
      valid[i] = isSparse && some(generator) ? 0 : -1;
      setRay(&packet, N, i, rays[first + i]);
    }
    any = packet.ray;
    intersect(valid, scene, packet, Query{isCoherent});
    occluded(valid, scene, any, Query{isCoherent});
    for (unsigned i = 0; i < N; i++) {
      RTCRayHit found = rtcGetRayHitFromRayHitN((RTCRayHitN*)&packet, N, i);
      if (valid[i]) checkHit(group, rays[first + i], found, 0, RTC_INVALID_GEOMETRY_ID);
      else CHECK(std::memcmp(&found.ray, &rays[first + i].ray, sizeof(found.ray)) == 0 && !isHit(found));
      CHECK((any.tfar[i] < 0) == (valid[i] && isAnyHit(scene, rays[first + i].ray)));
    }
  }
}

void testHits(RTCDevice device, CbvhContext context) {
  for (unsigned numSteps : {1u, 2u})
    for (unsigned count : {1u, 5u}) {
      const Group group(context, 32, count, numSteps);
      const Scene scene(device, group);
      for (bool areCoherent : {false, true}) {
        const std::vector<RTCRayHit> rays = randomRays(generator, 8000, areCoherent);
        size_t hits = 0;
        for (const RTCRayHit& ray : rays) {
          RTCRayHit found = ray;
          intersect(scene, found);
          checkHit(group, ray, found, 0, RTC_INVALID_GEOMETRY_ID);
          CHECK(isAnyHit(scene, ray.ray) == isHit(found));
          hits += isHit(found);
        }
        CHECK(hits > 500);
        checkPackets<4>(group, scene, rays, areCoherent);
        if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED))
          checkPackets<8>(group, scene, rays, areCoherent);
        const bool has16 = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
        checkPackets<16>(group, scene, rays, areCoherent, has16);
      }
    }
}

// Next to geometry of Embree, in front of it and after it along rays.
void testScenes(RTCDevice device, CbvhContext context) {
  const Group group(context);
  Scene scene(device, group);
  const Cube other({0.7f, 0.3f, 0.2f}, 0.5f);
  RTCGeometry geometry = other.newInHost(device, 16);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetGeometryMask(scene.geometry, ~0u);
  rtcCommitGeometry(scene.geometry);
  rtcCommitScene(scene);
  Scene alone(device, nullptr);
  geometry = other.newInHost(device, 16);
  rtcAttachGeometryByID(alone, geometry, 1);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(alone);
  size_t hits[2] = {0, 0};
  for (const RTCRayHit& ray : randomRays(generator, 6000, false)) {
    RTCRayHit found = ray, ofOther = ray;
    intersect(scene, found);
    intersect(alone, ofOther);
    CbvhRayHit own;
    std::memcpy(&own, &ray, sizeof(own));
    cbvhIntersect1(group, &own, nullptr);
    const bool isOurs = own.ray.tfar <= ofOther.ray.tfar && own.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    CHECK(found.ray.tfar == std::min(own.ray.tfar, ofOther.ray.tfar));
    if (!isHit(found)) continue;
    CHECK(found.hit.geomID == (isOurs ? 0u : 1u) || own.ray.tfar == ofOther.ray.tfar);
    hits[found.hit.geomID]++;
  }
  CHECK(hits[0] > 300 && hits[1] > 300);
}

void testMasks(RTCDevice device, CbvhContext context) {
  const Group group(context, 16, 2);
  Scene scene(device, group);
  rtcSetGeometryMask(scene.geometry, 6);
  rtcCommitGeometry(scene.geometry);
  rtcCommitScene(scene);
  OK(cbvhSetSurfaceMask(cbvhGetGroupSurface(group, 1), 4));
  OK(cbvhCommitGroup(group));
  size_t hits[8] = {};
  for (unsigned mask : {1u, 2u, 4u})
    for (RTCRayHit ray : randomRays(generator, 3000, false, 0.6f)) {
      ray.ray.mask = mask;
      RTCRayHit found = ray;
      intersect(scene, found);
      CHECK(isHit(found) == isAnyHit(scene, ray.ray));
      size_t surface = 0;
      unsigned primID;
      if (!isHit(found)) continue;
      CHECK(cbvhFindGroupPrimitive(group, found.hit.primID, &surface, &primID));
      CHECK(mask == 4 || surface == 0);
      hits[mask] += 1 + 10000 * surface;
    }
  CHECK(hits[1] == 0);
  CHECK(hits[2] > 100 && hits[2] < 10000);
  CHECK(hits[4] > 100 * 10000);
}

unsigned filtered = 0;

// Rejects hits depending on primID and u, and checks the IDs.
void filter(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++) {
    if (args->valid[i] == 0) continue;
    filtered++;
    CHECK(RTCHitN_geomID(args->hit, args->N, i) == 0);
    CHECK(RTCHitN_primID(args->hit, args->N, i) < 12);
    CHECK(RTCRayN_tfar(args->ray, args->N, i) < 100);
    if (RTCHitN_primID(args->hit, args->N, i) % 3 == 0 || RTCHitN_u(args->hit, args->N, i) > 0.6f) args->valid[i] = 0;
  }
}

void testFilters(RTCDevice device, CbvhContext context) {
  const Group group(context, 32, 2);
  const Scene plain(device, group, 0), byContext(device, group, contextFilters);
  Scene byGeometry(device, group, CBVH_GEOMETRY_FLAG_FILTERS);
  rtcSetGeometryIntersectFilterFunction(byGeometry.geometry, filter);
  rtcSetGeometryOccludedFilterFunction(byGeometry.geometry, filter);
  rtcCommitGeometry(byGeometry.geometry);
  rtcCommitScene(byGeometry);
  Query withFilter;
  withFilter.filter = filter;
  size_t hits = 0, others = 0;
  for (const RTCRayHit& ray : randomRays(generator, 6000, false, 0.6f)) {
    RTCRayHit first = ray, a = ray, b = ray;
    intersect(plain, first);
    filtered = 0;
    intersect(byGeometry, a);
    CHECK(!isHit(first) || filtered > 0);
    intersect(byContext, b, withFilter);
    CHECK(std::memcmp(&a.ray, &b.ray, sizeof(a.ray)) == 0);
    CHECK(a.hit.primID == b.hit.primID && a.hit.geomID == b.hit.geomID);
    CHECK(isAnyHit(byGeometry, ray.ray) == isHit(a));
    CHECK(isAnyHit(byContext, ray.ray, withFilter) == isHit(a));
    hits += isHit(a);
    others += a.hit.primID != first.hit.primID;
    if (isHit(a)) CHECK(a.hit.primID % 3 != 0 && a.hit.u <= 0.6f);
  }
  CHECK(hits > 200 && others > 200);

  /* packets must match single rays */
  const std::vector<RTCRayHit> rays = randomRays(generator, 4000, true, 0.6f);
  alignas(64) int valid[8];
  std::fill(valid, valid + 8, -1);
  for (size_t first = 0; first + 8 <= rays.size(); first += 8)
    for (const Scene* scene : {&byContext, (const Scene*)&byGeometry}) {
      const Query query = scene == &byContext ? withFilter : Query();
      RTCRayHit8 packet;
      for (unsigned i = 0; i < 8; i++) setRay(&packet, 8, i, rays[first + i]);
      RTCRay8 any = packet.ray;
      intersect(valid, *scene, packet, query);
      occluded(valid, *scene, any, query);
      for (unsigned i = 0; i < 8; i++) {
        RTCRayHit one = rays[first + i];
        intersect(*scene, one, query);
        CHECK(packet.ray.tfar[i] == one.ray.tfar);
        CHECK(packet.hit.geomID[i] == one.hit.geomID);
        CHECK(!isHit(one) || packet.hit.primID[i] == one.hit.primID);
        CHECK((any.tfar[i] < 0) == isHit(one));
      }
    }
}

void changeHit(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++) {
    if (args->valid[i] == 0) continue;
    RTCRayN_tfar(args->ray, args->N, i) *= 0.5f;
    RTCHitN_Ng_x(args->hit, args->N, i) = 1;
    RTCHitN_Ng_y(args->hit, args->N, i) = 2;
    RTCHitN_Ng_z(args->hit, args->N, i) = 3;
    RTCHitN_u(args->hit, args->N, i) = 0.125f;
    RTCHitN_v(args->hit, args->N, i) = 0.375f;
    RTCHitN_primID(args->hit, args->N, i) += 100;
  }
}

// Embree lets filters change hits that they accept, and decrease tfar.
void testChangingFilters(RTCDevice device, CbvhContext context) {
  const Group group(context, 32, 2);
  const Scene plain(device, group, 0), byContext(device, group, contextFilters);
  Scene byGeometry(device, group, CBVH_GEOMETRY_FLAG_FILTERS);
  rtcSetGeometryIntersectFilterFunction(byGeometry.geometry, changeHit);
  rtcCommitGeometry(byGeometry.geometry);
  rtcCommitScene(byGeometry);
  Query withFilter;
  withFilter.filter = changeHit;
  const std::vector<RTCRayHit> rays = randomRays(generator, 4000, true, 0.6f);
  size_t hits = 0, halves = 0;
  alignas(64) int valid[8];
  std::fill(valid, valid + 8, -1);
  for (const Scene* scene : {&byContext, (const Scene*)&byGeometry})
    for (size_t first = 0; first + 8 <= rays.size(); first += 8) {
      const Query query = scene == &byContext ? withFilter : Query();
      RTCRayHit8 packet;
      for (unsigned i = 0; i < 8; i++) setRay(&packet, 8, i, rays[first + i]);
      intersect(valid, *scene, packet, query);
      for (unsigned i = 0; i < 8; i++) {
        RTCRayHit unchanged = rays[first + i], one = unchanged;
        intersect(plain, unchanged);
        intersect(*scene, one, query);
        CHECK(isHit(one) == isHit(unchanged));
        CHECK((packet.hit.geomID[i] == 0) == isHit(unchanged));
        if (!isHit(unchanged)) continue;
        hits++;
        halves += one.ray.tfar == 0.5f * unchanged.ray.tfar; // of farther hits, those that were found first
        CHECK(one.ray.tfar >= 0.5f * unchanged.ray.tfar && packet.ray.tfar[i] >= 0.5f * unchanged.ray.tfar);
        CHECK(one.hit.geomID == 0 && one.hit.primID >= 100 && one.hit.primID < 112);
        CHECK(packet.hit.primID[i] >= 100 && packet.hit.primID[i] < 112);
        CHECK(one.ray.tfar != 0.5f * unchanged.ray.tfar || one.hit.primID == unchanged.hit.primID + 100);
        CHECK(one.hit.Ng_x == 1 && one.hit.Ng_y == 2 && one.hit.Ng_z == 3);
        CHECK(one.hit.u == 0.125f && one.hit.v == 0.375f);
        CHECK(packet.hit.Ng_x[i] == 1 && packet.hit.Ng_z[i] == 3 && packet.hit.v[i] == 0.375f);
      }
    }
  CHECK(hits > 400 && halves > hits / 2);
}

void testInstances(RTCDevice device, CbvhContext context) {
  const Group group(context);
  const Scene inside(device, group);
  Scene scene(device, nullptr);
  for (int i = 0; i < 3; i++) {
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, inside);
    const float transform[12] = {0.25f, 0, 0, 0, 0.25f, 0, 0, 0, 0.25f, 0.5f * float(i) - 0.5f, 0, 0};
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
    rtcSetGeometryMask(instance, ~0u);
    rtcCommitGeometry(instance);
    rtcAttachGeometryByID(scene, instance, unsigned(5 + i));
    rtcReleaseGeometry(instance);
  }
  rtcCommitScene(scene);
  size_t hits[3] = {0, 0, 0};
  for (const RTCRayHit& ray : randomRays(generator, 6000, false, 0.5f)) {
    RTCRayHit found = ray;
    intersect(scene, found);
    CHECK(isHit(found) == isAnyHit(scene, ray.ray));
    if (!isHit(found)) continue;
    const unsigned i = found.hit.instID[0] - 5;
    CHECK(i < 3);
    if (i >= 3) continue;
    hits[i]++;
    CHECK(found.hit.geomID == 0);
    /* the same ray in instance space */
    RTCRayHit local = ray;
    local.ray.org_x = 4 * (ray.ray.org_x - (0.5f * float(i) - 0.5f));
    local.ray.org_y *= 4;
    local.ray.org_z *= 4;
    local.ray.dir_x *= 4;
    local.ray.dir_y *= 4;
    local.ray.dir_z *= 4;
    CbvhRayHit own;
    std::memcpy(&own, &local, sizeof(own));
    CHECK(cbvhIntersect1(group, &own, nullptr));
    CHECK(std::fabs(own.ray.tfar - found.ray.tfar) < 1e-4f * found.ray.tfar);
    CHECK(own.hit.primID == found.hit.primID);
  }
  for (size_t n : hits) CHECK(n > 100);
}

// Compares with Embree's subdivision surface, which is nearly the same.
void testSurface(RTCDevice device, CbvhContext context) {
  const Group group(context, 64);
  const Scene ours(device, group);
  Scene theirs(device, nullptr);
  RTCGeometry geometry = Cube().newInHost(device, 64);
  rtcAttachGeometry(theirs, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(theirs);
  size_t hits = 0, others = 0;
  for (const RTCRayHit& ray : randomRays(generator, 5000, false)) {
    RTCRayHit a = ray, b = ray;
    intersect(theirs, a);
    intersect(ours, b);
    hits += isHit(a);
    others += isHit(a) != isHit(b) ||
              (isHit(a) && (a.hit.primID != b.hit.primID || std::fabs(a.ray.tfar - b.ray.tfar) > 1e-3f));
  }
  CHECK(hits > 1000);
  CHECK(others < hits / 200);
}

// Ten thousand surfaces. Each ray must hit the surface at which it is aimed.
void testManySurfaces(RTCDevice device, CbvhContext context) {
  constexpr int side = 100;
  const auto middle = [](int i) { return Vec{0.03f * float(i % side) - 1.5f, 0.03f * float(i / side) - 1.5f, 0}; };
  std::vector<CbvhSurface> surfaces;
  for (int i = 0; i < side * side; i++) {
    const Cube cube(middle(i), 0.012f);
    CbvhCage cage = cube.cage(2);
    cage.displacement = nullptr; // larger than the distance of the cubes
    surfaces.push_back(nullptr);
    OK(cbvhNewSurface(context, &surfaces.back()));
    OK(cbvhSetSurfaceCage(surfaces.back(), &cage));
    OK(cbvhCommitSurface(surfaces.back(), nullptr, nullptr));
  }
  CbvhGroup group = nullptr;
  OK(cbvhNewGroup(context, surfaces.data(), surfaces.size(), &group));
  OK(cbvhCommitGroup(group));
  for (CbvhSurface surface : surfaces) cbvhReleaseSurface(surface);
  CHECK(cbvhGetGroupSurfaceCount(group) == size_t(side * side));
  {
    const Scene scene(device, group);
    for (int i = 0; i < side * side; i++) {
      const Vec at = middle(i);
      RTCRayHit ray = makeRay({at[0], at[1], 4}, {0, 0, -1});
      intersect(scene, ray);
      size_t surface = 0;
      unsigned primID = 0;
      CHECK(isHit(ray));
      CHECK(isHit(ray) && cbvhFindGroupPrimitive(group, ray.hit.primID, &surface, &primID) && surface == size_t(i) &&
            primID < 6);
    }
  }
  size_t surface;
  unsigned primID;
  CHECK(!cbvhFindGroupPrimitive(group, 6 * side * side, &surface, &primID));
  cbvhReleaseGroup(group);
}

// Scenes must use the new bounds of a changed group.
void testEdits(RTCDevice device, CbvhContext context) {
  const Group group(context);
  const Scene scene(device, group);
  const CbvhSurface surface = cbvhGetGroupSurface(group, 0);
  const Cube moved({5, 0, 0});
  const CbvhCage cage = moved.cage(32);
  OK(cbvhSetSurfaceCage(surface, &cage));
  OK(cbvhCommitSurface(surface, nullptr, nullptr));
  OK(cbvhCommitGroup(group));
  rtcCommitGeometry(scene.geometry);
  rtcCommitScene(scene);
  CHECK(!isAnyHit(scene, makeRay({0.1f, 0.2f, 5}, {0, 0, -1}).ray));
  CHECK(isAnyHit(scene, makeRay({5.1f, 0.2f, 5}, {0, 0, -1}).ray));
}

// --- lossless surfaces and the host's own kernels -------------------------------------------------------

void setHostBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, size_t stride,
                   size_t count, const void* data) {
  std::memcpy(rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count), data, stride * count);
}

void setHostVertices(RTCGeometry geometry, const CbvhVertices& vertices) {
  rtcSetGeometryTimeStepCount(geometry, vertices.numSteps);
  for (unsigned i = 0; i < vertices.numSteps; i++)
    setHostBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, i, RTC_FORMAT_FLOAT3, sizeof(Vec), vertices.numVertices,
                  vertices.steps[i]);
}

double cosineOf(const RTCRayHit& r) {
  const double d[3] = {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z}, n[3] = {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z};
  double dn = 0, dd = 0, nn = 0;
  for (int k = 0; k < 3; k++) {
    dn += d[k] * n[k];
    dd += d[k] * d[k];
    nn += n[k] * n[k];
  }
  return std::fabs(dn) / std::sqrt(dd * nn);
}

/* The same primitive, and distances and parameters that differ by rounding, which is larger for grazing rays. GRID
 * stores 13 bits of parameters. A few rays may hit the other side of an edge. geometry: committed and released
 * here. */
void checkHostsHits(RTCDevice device, CbvhContext context, CbvhSurface surface, RTCGeometry geometry,
                    const char* what) {
  OK(cbvhSetSurfaceLossless(surface, 1));
  OK(cbvhCommitSurface(surface, nullptr, nullptr));
  const Group group(context, surface);
  CbvhGroupStatistics statistics;
  OK(cbvhGetGroupStatistics(group, &statistics));
  CHECK(statistics.numQuads > 0);
  CHECK(statistics.maxVertexDeviation == 0);
  const Scene ours(device, group);
  const Scene hosts(device, nullptr);
  rtcSetGeometryMask(geometry, ~0u); // the default of Embree 4 is 1
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(hosts, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(hosts);
  size_t hits = 0, others = 0;
  for (bool areCoherent : {false, true})
    for (const RTCRayHit& ray : randomRays(generator, 8000, areCoherent)) {
      RTCRayHit found = ray, expected = ray;
      intersect(ours, found);
      intersect(hosts, expected);
      CHECK(isAnyHit(ours, ray.ray) == isHit(found));
      if (!isHit(expected) && !isHit(found)) continue;
      hits++;
      const double grazing = isHit(expected) ? std::max(1.0, 0.1 / cosineOf(expected)) : 1;
      others += isHit(expected) != isHit(found) || expected.hit.primID != found.hit.primID ||
                std::fabs(expected.ray.tfar - found.ray.tfar) > 1e-5 * expected.ray.tfar * grazing ||
                std::fabs(expected.hit.u - found.hit.u) > 2e-3 * grazing ||
                std::fabs(expected.hit.v - found.hit.v) > 2e-3 * grazing;
    }
  CHECK(hits > 3000);
  CHECK(others <= hits / 1000);
  if (failures) std::fprintf(stderr, "%s: %zu of %zu hits differ\n", what, others, hits);
}

void testLossless(RTCDevice device, CbvhContext context) {
  const unsigned side = 65; // vertices, in four grids
  std::vector<Vec> vertices[2];
  std::vector<unsigned> quads, triangles;
  for (unsigned step = 0; step < 2; step++)
    for (unsigned y = 0; y < side; y++)
      for (unsigned x = 0; x < side; x++) {
        const float u = 2 * float(x) / float(side - 1) - 1, v = 2 * float(y) / float(side - 1) - 1;
        const float s = float(step);
        vertices[step].push_back({u + 0.1f * s * v, v - 0.05f * s * u, 0.2f * std::sin(5 * u + s) * std::cos(4 * v)});
      }
  for (auto& step : vertices) step.push_back({0, 0, 0}); // the library reads 4 bytes after the last vertex
  for (unsigned y = 0; y + 1 < side; y++)
    for (unsigned x = 0; x + 1 < side; x++) {
      const unsigned a = y * side + x, b = a + 1, c = a + side, d = c + 1;
      for (unsigned i : {a, b, d, c}) quads.push_back(i);
      for (unsigned i : {a, b, c, d, c, b}) triangles.push_back(i);
    }
  const float* const steps[] = {vertices[0][0].data(), vertices[1][0].data()};
  const Cube cube;
  for (unsigned numSteps : {1u, 2u}) {
    CbvhVertices input = {size_t(side) * side, sizeof(Vec), steps, numSteps, 0, 1};
    CbvhSurface surface = nullptr;
    OK(cbvhNewSurface(context, &surface));

    const CbvhCage cage = cube.cage(32, numSteps);
    OK(cbvhSetSurfaceCage(surface, &cage));
    RTCGeometry geometry = cube.newInHost(device, 32, numSteps);
    checkHostsHits(device, context, surface, geometry, "a cage");

    std::vector<CbvhGrid> grids;
    std::vector<RTCGrid> hostGrids;
    for (unsigned y : {0u, 32u})
      for (unsigned x : {0u, 32u}) {
        grids.push_back({y * side + x, side, 33, 33});
        hostGrids.push_back({y * side + x, side, 33, 33});
      }
    const CbvhGrids ofGrids = {sizeof(CbvhGrids), grids.size(), grids.data(), input};
    OK(cbvhSetSurfaceGrids(surface, &ofGrids));
    geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    setHostVertices(geometry, input);
    setHostBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), hostGrids.size(),
                  hostGrids.data());
    checkHostsHits(device, context, surface, geometry, "grids");

    for (unsigned corners : {4u, 3u}) {
      const std::vector<unsigned>& indices = corners == 4 ? quads : triangles;
      const CbvhMesh mesh = {sizeof(CbvhMesh), corners, indices.size() / corners, indices.data(), input};
      OK(cbvhSetSurfaceMesh(surface, &mesh));
      geometry = rtcNewGeometry(device, corners == 4 ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
      setHostVertices(geometry, input);
      const RTCFormat format = corners == 4 ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3;
      setHostBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, format, 4 * corners, mesh.numFaces, mesh.indices);
      checkHostsHits(device, context, surface, geometry, corners == 4 ? "quads" : "triangles");
    }
    cbvhReleaseSurface(surface);
  }
}

} // namespace

// primID has 32 bits: a group with more primitives cannot become a geometry of Embree.
void testTooManyPrimitives(RTCDevice device, CbvhContext context) {
  const unsigned side = 1449; // vertices
  std::vector<Vec> vertices;
  std::vector<unsigned> indices;
  for (unsigned y = 0; y < side; y++)
    for (unsigned x = 0; x < side; x++) {
      vertices.push_back({float(x), float(y), 0});
      if (x + 1 == side || y + 1 == side) continue;
      const unsigned a = y * side + x;
      for (unsigned i : {a, a + 1, a + side, a + side + 1, a + side, a + 1}) indices.push_back(i);
    }
  vertices.push_back({0, 0, 0}); // the library reads 4 bytes after the last vertex
  const float* const steps[] = {vertices[0].data()};
  CbvhMesh mesh = CbvhMesh();
  mesh.verticesPerFace = 3;
  mesh.numFaces = indices.size() / 3;
  mesh.indices = indices.data();
  mesh.vertices = {vertices.size() - 1, sizeof(Vec), steps, 1, 0, 0};
  CbvhSurface surface = nullptr;
  OK(cbvhNewSurface(context, &surface));
  OK(cbvhSetSurfaceMesh(surface, &mesh));
  OK(cbvhCommitSurface(surface, nullptr, nullptr));
  for (size_t count : {2, 1025}) {
    const std::vector<CbvhSurface> surfaces(count, surface);
    CbvhGroup group = nullptr;
    OK(cbvhNewGroup(context, surfaces.data(), count, &group));
    OK(cbvhCommitGroup(group));
    RTCGeometry geometry = cbvhNewGeometry(device, group, 0);
    CHECK((geometry != nullptr) == (count * mesh.numFaces < 0xFFFFFFFFu));
    CHECK(geometry || std::string(cbvhGetErrorText()).find("4294967295") != std::string::npos);
    CHECK(geometry || cbvhCheckGeometry(group, 0, 0) == CBVH_ERROR_INVALID_OPERATION);
    if (geometry) rtcReleaseGeometry(geometry);
    cbvhReleaseGroup(group);
  }
  cbvhReleaseSurface(surface);
}

// Unknown flags may be known to a later version of the header: ignoring them would trace without filters.
void testUnknownFlags(RTCDevice device) {
  std::string reported;
  const auto keep = [](void* to, CbvhError code, const char* text) {
    CHECK(code == CBVH_ERROR_INVALID_ARGUMENT);
    *(std::string*)to = text;
  };
  CbvhContext context = nullptr;
  OK(cbvhNewContext(nullptr, keep, &reported, &context));
  {
    const Group group(context);
    const struct {
      unsigned flags;
      const char* named;
    } unknown[] = {
        {4, "0x4 "},
        {CBVH_GEOMETRY_FLAG_FILTERS | 0x80000000u, "0x80000000 "},
        {~0u, RTC_VERSION_MAJOR < 4 ? "0xfffffffe " : "0xfffffffc "},
#if RTC_VERSION_MAJOR < 4
        {2, "0x2 "},
#endif
    };
    for (const auto& each : unknown) {
      reported.clear();
      CHECK(cbvhNewGeometry(device, group, each.flags) == nullptr);
      CHECK(reported.find(each.named) != std::string::npos);
      CHECK(cbvhGetErrorText() == reported);
    }
    reported.clear();
    const unsigned filters = CBVH_GEOMETRY_FLAG_FILTERS;
    for (unsigned flags : {0u, filters, contextFilters, filters | contextFilters}) {
      RTCGeometry geometry = cbvhNewGeometry(device, group, flags);
      CHECK(geometry != nullptr);
      if (geometry) rtcReleaseGeometry(geometry);
    }
    CHECK(reported.empty());
  }
  cbvhReleaseContext(context);
  CHECK(cbvhNewGeometry(device, nullptr, 0) == nullptr);
}

int main() {
  RTCDevice device = rtcNewDevice(nullptr);
  CHECK(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION) == RTC_VERSION);
  CbvhContext context = nullptr;
  OK(cbvhNewContext(nullptr, nullptr, nullptr, &context));
  testHits(device, context);
  testLossless(device, context);
  testScenes(device, context);
  testMasks(device, context);
  testFilters(device, context);
  testChangingFilters(device, context);
  testInstances(device, context);
  testSurface(device, context);
  testManySurfaces(device, context);
  testEdits(device, context);
  testTooManyPrimitives(device, context);
  testUnknownFlags(device);
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  rtcReleaseDevice(device);
  cbvhReleaseContext(context);
  return conclude("hits");
}
