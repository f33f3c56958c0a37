// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The triangle of a hit, and all triangles. */

#include "support/diced.h"
#include "support/edge_rates.h"
#include "support/memory.h"
#include "support/surface_access.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <set>
#include <thread>

namespace programs::test { namespace {

using Triangle = std::array<Vec, 3>;

// Collects all parts.
struct AllParts {
  std::map<unsigned, std::set<Triangle>> triangles; // by primID
  size_t quads = 0, calls = 0, mostCalls = ~size_t(0);

  explicit AllParts(RTCGeometry geometry) { forEachStoredPart(geometry, 0, add, this); }

  static bool add(void* self, const CbvhPart* part) {
    AllParts& all = *(AllParts*)self;
    all.calls++;
    const auto at = [&](unsigned x, unsigned y) {
      const float* p = part->vertices + 3 * (y * part->width + x);
      return Vec{p[0], p[1], p[2]};
    };
    const auto isNumber = [](const Vec& p) {
      return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    };
    for (unsigned i = 0; i < part->width * part->height; i++)
      EXPECT_TRUE(part->parameters[2 * i] >= 0 && part->parameters[2 * i + 1] >= 0);
    for (unsigned y = 0; y + 1 < part->height; y++)
      for (unsigned x = 0; x + 1 < part->width; x++) {
        const Vec a = at(x, y), b = at(x + 1, y), c = at(x, y + 1), d = at(x + 1, y + 1);
        all.quads += isNumber(a) && isNumber(b) && isNumber(c) && isNumber(d);
        if (isNumber(a) && isNumber(b) && isNumber(c)) all.triangles[part->primID].insert({a, b, c});
        if (isNumber(c) && isNumber(b) && isNumber(d)) all.triangles[part->primID].insert({c, b, d});
      }
    return all.calls < all.mostCalls;
  }
};

// The triangles of hits contain the hits, have their normals and parameters, and are among all triangles.
void expectTrianglesOfHits(RTCScene scene, RTCGeometry geometry, const std::vector<RTCRayHit>& rays) {
  const AllParts all(geometry);
  size_t hits = 0;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit r = intersect(scene, ray);
    if (!isHit(r)) continue;
    hits++;
    SCOPED_TRACE(testing::Message() << "primID " << r.hit.primID << ", u " << r.hit.u << ", v " << r.hit.v);
    CbvhTriangle t;
    ASSERT_TRUE(findStoredTriangle(geometry, 0, r.hit.primID, r.hit.u, r.hit.v, &r.hit.Ng_x, &t));
    Triangle vertices;
    for (int c = 0; c < 3; c++) std::copy_n(t.vertices[c], 3, vertices[c].begin());
    ASSERT_TRUE(all.triangles.count(r.hit.primID) && all.triangles.at(r.hit.primID).count(vertices));

    double e1[3], e2[3], s[3], n[3], nn = 0, dn = 0, gn = 0, gg = 0;
    const float direction[3] = {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z}, Ng[3] = {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z};
    const float origin[3] = {r.ray.org_x, r.ray.org_y, r.ray.org_z};
    for (int k = 0; k < 3; k++) {
      e1[k] = double(t.vertices[1][k]) - t.vertices[0][k];
      e2[k] = double(t.vertices[2][k]) - t.vertices[0][k];
      s[k] = origin[k] + double(r.ray.tfar) * direction[k] - t.vertices[0][k];
    }
    const auto cross = [](const double a[3], const double b[3], int k) {
      return a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    };
    for (int k = 0; k < 3; k++) {
      n[k] = cross(e1, e2, k);
      nn += n[k] * n[k];
      dn += n[k] * direction[k];
      gn += n[k] * Ng[k];
      gg += double(Ng[k]) * Ng[k];
    }
    ASSERT_GT(gn * gn, 0.9999 * nn * gg) << "Ng";
    double w1 = 0, w2 = 0, off = 0;
    for (int k = 0; k < 3; k++) {
      w1 += cross(s, e2, k) * n[k] / nn;
      w2 += cross(e1, s, k) * n[k] / nn;
      off += s[k] * n[k];
    }
    // a grazing ray
    if (std::fabs(dn) < 0.05 * std::sqrt(nn) *
                            std::sqrt(double(direction[0]) * direction[0] + double(direction[1]) * direction[1] +
                                      double(direction[2]) * direction[2]))
      continue;
    ASSERT_GT(std::min({w1, w2, 1 - w1 - w2}), -0.02);
    ASSERT_LT(std::fabs(off) / std::sqrt(nn), 1e-5 * std::max(1.0f, r.ray.tfar));
    ASSERT_NEAR(t.u[0] + w1 * (t.u[1] - t.u[0]) + w2 * (t.u[2] - t.u[0]), r.hit.u, 1e-3);
    ASSERT_NEAR(t.v[0] + w1 * (t.v[1] - t.v[0]) + w2 * (t.v[2] - t.v[0]), r.hit.v, 1e-3);
  }
  EXPECT_GT(hits, rays.size() / 4);
}

TEST(StoredTriangles, CagesMatchHitTriangles) {
  Device device;
  Random random(111);
  Displacement displacement;
  const struct {
    const char* name;
    Cage cage;
  } cages[] = {{"cube", cubeCage()},
               {"pentagons", prismCage(5)},
               {"triangles", prismCage(3)},
               {"valence 9", trapezohedronCage(9)}};
  for (const auto& c : cages)
    for (int i = 0; i < 4; i++) {
      const bool mixed = i & 1, isGrid = i & 2;
      SCOPED_TRACE(testing::Message() << c.name << (isGrid ? ", cGRID" : "") << (mixed ? ", mixed rates" : ""));
      SurfaceSettings settings;
      settings.compression = isGrid ? RTC_COMPRESSION_CGRID : RTC_COMPRESSION_CVERT;
      settings.displacement = &displacement;
      settings.rate = 20;
      if (mixed)
        for (size_t i = 0; i < c.cage.indices.size(); i++) settings.edgeRates.push_back(float(1 + random.below(40)));
      Scene scene(device);
      RTCGeometry geometry = newSurface(device, c.cage, settings);
      attach(scene, geometry);
      rtcCommitScene(scene);
      expectTrianglesOfHits(scene, geometry, raysAt(random, 600));
      const AllParts all(geometry);
      EXPECT_EQ(all.quads, statisticsOf(scene).numQuads);
    }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(StoredTriangles, GridsMatchHitTriangles) {
  Device device;
  Random random(112);
  Diced poisoned = dicedSheet(3, 20);
  for (int i = 0; i < 5; i++) poisoned.vertices[random.below(unsigned(poisoned.vertices.size()))][1] = NAN;
  for (const Diced& diced : {dicedSheet(1, 50), dicedBall(2, 9), poisoned}) {
    Scene scene(device);
    RTCGeometry geometry = newGrids(device, diced, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT);
    attach(scene, geometry);
    rtcCommitScene(scene);
    device.takeError();
    std::vector<RTCRayHit> rays;
    for (int i = 0; i < 600; i++) rays.push_back(rayAt(random, diced));
    expectTrianglesOfHits(scene, geometry, rays);
    const AllParts all(geometry);
    EXPECT_EQ(all.quads + statisticsOf(scene).numInvalidQuads, diced.quads());
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// Devices whose rays hit with the same bits return the same vertices, also if the library does not contain a device's
// ISA and traces with a lower one.
TEST(StoredTriangles, VerticesBetweenTimeStepsAreRoundedAsByTraversal) {
  struct Result {
    std::string isa;
    std::vector<float> hits;
    std::vector<Vec> vertices;
  };
  Random random(113);
  Diced diced = dicedSheet(2, 16);
  diced.motion = [](const Vec& p, unsigned step) {
    return Vec{p[0] + 0.03f * step, p[1] * (1 + 0.1f * step), p[2] - 0.07f * step * p[0]};
  };
  const float time = 0.3f;
  std::vector<RTCRayHit> rays;
  for (int i = 0; i < 500; i++) {
    rays.push_back(rayAt(random, diced));
    rays.back().ray.time = time;
  }
  std::vector<Result> results;
  size_t numComparisons = 0;
  for (const char* isa : {"", "isa=sse2", "isa=sse4.2", "isa=avx", "isa=avx2", "isa=avx512"}) {
    Device device(isa);
    if (!device) continue; // this machine does not support the ISA
    Scene scene(device);
    RTCGeometry geometry = newGrids(device, diced, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_NONE, 2);
    attach(scene, geometry);
    rtcCommitScene(scene);
    Result result;
    result.isa = isa;
    for (const RTCRayHit& ray : rays) {
      const RTCRayHit r = intersect(scene, ray);
      if (!isHit(r)) continue;
      for (float x : {r.ray.tfar, r.hit.u, r.hit.v, r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}) result.hits.push_back(x);
    }
    EXPECT_GT(result.hits.size(), 6u * 100u);
    forEachStoredPart(
        geometry, time,
        [](void* vertices, const CbvhPart* part) {
          for (unsigned i = 0; i < part->width * part->height; i++) {
            const float* p = part->vertices + 3 * i;
            ((std::vector<Vec>*)vertices)->push_back({p[0], p[1], p[2]});
          }
          return true;
        },
        &result.vertices);
    std::sort(result.vertices.begin(), result.vertices.end()); // the order of parts is unspecified
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    for (const Result& other : results) {
      if (other.hits != result.hits) continue;
      numComparisons++;
      EXPECT_TRUE(other.vertices == result.vertices) << "'" << other.isa << "' and '" << isa << "'";
    }
    results.push_back(result);
  }
  EXPECT_GT(numComparisons, 0u) << "the default is one of the ISAs";
}

// Point queries call for faces, whose closest points bound the radius. Embree has no point queries for cages.
TEST(StoredTriangles, PointQueriesFindTheClosestFaces) {
  Device device;
  Random random(64);
  Displacement displacement;
  displacement.amplitude = 0.1;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = 20;
  for (RTCCompression compression : {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE}) {
    settings.compression = compression;
    Scene scene(device);
    addSurface(device, scene, cubeCage(), settings);
    rtcCommitScene(scene);
    const RTCGeometry geometry = rtcGetGeometry(scene, 0);
    struct Search {
      RTCGeometry geometry;
      float p[3];
      unsigned calls;
      CbvhClosestPoint closest;
    };
    const RTCPointQueryFunction visit = [](RTCPointQueryFunctionArguments* args) {
      Search& search = *(Search*)args->userPtr;
      search.calls++;
      if (!OF_LIBEMBREE3(cbvhFindClosestPoint)(SurfaceOfGeometry(search.geometry), 0, args->primID, search.p,
                                               args->query->radius, &search.closest))
        return false;
      args->query->radius = search.closest.distance;
      return true;
    };
    unsigned calls = 0;
    for (int i = 0; i < 100; i++) {
      Search search = {geometry, {}, 0, CbvhClosestPoint()};
      for (float& x : search.p) x = float(random.uniform(-2, 2));
      RTCPointQuery query = {search.p[0], search.p[1], search.p[2], 0, INFINITY};
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      ASSERT_TRUE(rtcPointQuery(scene, &query, &context, visit, &search));
      float nearest = INFINITY;
      for (unsigned primID = 0; primID < 6; primID++) {
        CbvhClosestPoint ofFace;
        ASSERT_TRUE(
            OF_LIBEMBREE3(cbvhFindClosestPoint)(SurfaceOfGeometry(geometry), 0, primID, search.p, INFINITY, &ofFace));
        nearest = std::min(nearest, ofFace.distance);
      }
      ASSERT_EQ(search.closest.distance, nearest);
      ASSERT_EQ(query.radius, nearest);
      calls += search.calls;
    }
    EXPECT_LT(calls, 100u * 12) << "most of the 24 blocks are too far away";
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// The closest point of a scene. What has no stored triangles, or is in an instance, is an error if it is near.
TEST(StoredTriangles, ScenesHaveClosestPoints) {
  Device device;
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CTILE;
  Scene compressed(device);
  for (int i = 0; i < 2; i++) addSurface(device, compressed, cubeCage(), settings);
  CbvhPointQuery query = CbvhPointQuery();
  query.x = 3;
  query.radius = INFINITY;
  CbvhClosestPoint closest;
  EXPECT_FALSE(rtcFindClosestPoint(compressed, &query, &closest));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION) << "the scene is not committed";
  rtcCommitScene(compressed);
  ASSERT_TRUE(rtcFindClosestPoint(compressed, &query, &closest));
  EXPECT_EQ(closest.geomID, 0u);
  const RTCRayHit hit = intersect(compressed, makeRay({3, 0, 0}, {-1, 0, 0}));
  EXPECT_LE(closest.distance, hit.ray.tfar);
  EXPECT_NEAR(closest.distance, hit.ray.tfar, 1e-3);
  query.radius = 0.99f * closest.distance;
  EXPECT_FALSE(rtcFindClosestPoint(compressed, &query, &closest));
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  query.radius = INFINITY;
  query.y = NAN;
  EXPECT_FALSE(rtcFindClosestPoint(compressed, &query, &closest));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  query.y = 0;

  Scene instances(device);
  const RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, compressed);
  rtcCommitGeometry(instance);
  attach(instances, instance);
  rtcCommitScene(instances);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_FALSE(rtcFindClosestPoint(instances, &query, &closest));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_NE(device.message.find("instance"), std::string::npos) << device.message;

  Scene mixed(device);
  addSurface(device, mixed, cubeCage(), settings);
  const RTCGeometry triangle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE); // too small to be compressed
  setBuffer<Vec>(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, {{1.5f, 0, 0}, {1.5f, 0.1f, 0}, {1.5f, 0, 1}});
  setBuffer<unsigned>(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, {0, 1, 2});
  rtcCommitGeometry(triangle);
  attach(mixed, triangle);
  rtcCommitScene(mixed);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_FALSE(rtcFindClosestPoint(mixed, &query, &closest));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_NE(device.message.find("not compressed"), std::string::npos) << device.message;
}

TEST(StoredTriangles, ManyThreadsReadThem) {
  Device device;
  Scene scene(device);
  const Diced diced = dicedSheet(8, 8);
  RTCGeometry geometry = newGrids(device, diced, RTC_COMPRESSION_CVERT);
  attach(scene, geometry);
  rtcCommitScene(scene);
  std::vector<std::thread> threads;
  std::atomic<size_t> found{0};
  for (int i = 0; i < 8; i++)
    threads.emplace_back([&] {
      CbvhTriangle t;
      for (unsigned primID = 0; primID < diced.grids.size(); primID++)
        found += findStoredTriangle(geometry, 0, primID, 0.3f, 0.6f, nullptr, &t);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(found, 8 * diced.grids.size());
}

TEST(StoredTriangles, GeometriesWithoutTrianglesAreErrors) {
  Device device;
  CbvhTriangle t;
  const auto lookUp = [&](RTCGeometry geometry, unsigned primID = 0) {
    return findStoredTriangle(geometry, 0, primID, 0.5f, 0.5f, nullptr, &t);
  };
  const Diced diced = dicedSheet(2, 8);
  Scene scene(device);
  RTCGeometry geometry = newGrids(device, diced, RTC_COMPRESSION_CVERT),
              plain = newGrids(device, diced, RTC_COMPRESSION_NONE);
  EXPECT_FALSE(lookUp(geometry));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION) << "no scene was committed";
  attach(scene, geometry);
  attach(scene, plain);
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CLEAF;
  RTCGeometry leaves = newSurface(device, cubeCage(), settings);
  attach(scene, leaves);
  rtcCommitScene(scene);
  EXPECT_TRUE(lookUp(geometry));
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_FALSE(lookUp(geometry, 4));
  EXPECT_FALSE(findStoredTriangle(geometry, 0, 0, 1.5f, 0.5f, nullptr, &t));
  EXPECT_FALSE(findStoredTriangle(geometry, 0, 0, NAN, 0.5f, nullptr, &t));
  EXPECT_TRUE(findStoredTriangle(geometry, NAN, 0, 0.5f, 0.5f, nullptr, &t)) << "the geometry does not move";
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_FALSE(lookUp(plain));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_FALSE(lookUp(leaves));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_NE(device.message.find("cVERT"), std::string::npos) << device.message;
  RTCGeometry user = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  EXPECT_FALSE(lookUp(user));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_NE(device.message.find("triangles"), std::string::npos) << device.message;
  rtcReleaseGeometry(user);
  forEachStoredPart(geometry, 0, nullptr, nullptr);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(findStoredTriangle(geometry, 0, 0, 0.5f, 0.5f, nullptr, nullptr));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  size_t calls = 0;
  forEachStoredPart(geometry, 0, [](void* n, const CbvhPart*) { return ++*(size_t*)n < 3; }, &calls);
  EXPECT_EQ(calls, 3u) << "false ends the calls";
}

// Release the last reference, or commit without compression: blocks that are being read exist until the call returns.
TEST(StoredTriangles, CallbackMayReleaseOrCommitTheGeometry) {
  struct Callback {
    RTCGeometry geometry;
    bool releases;
    Memory& memory;
    size_t calls = 0;
    ssize_t freed = 0;

    static bool function(void* self, const CbvhPart* part) {
      Callback& callback = *(Callback*)self;
      EXPECT_GT(part->width, 1u);
      if (callback.calls++ != 0) return true;
      const ssize_t before = callback.memory.live;
      if (callback.releases) rtcReleaseGeometry(callback.geometry);
      else commitAs(callback.geometry, RTC_COMPRESSION_NONE, 0);
      callback.freed = before - callback.memory.live;
      return true;
    }
  };
  const Diced diced = dicedSheet(4, 64);
  for (bool releases : {true, false}) {
    SCOPED_TRACE(releases ? "releases" : "commits");
    Memory memory;
    Device device;
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    Callback callback = {newGrids(device, diced, RTC_COMPRESSION_CVERT), releases, memory};
    {
      Scene scene(device);
      rtcAttachGeometry(scene, callback.geometry);
      rtcCommitScene(scene);
    }
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const ssize_t before = memory.live;
    forEachStoredPart(callback.geometry, 0, Callback::function, &callback);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_GT(callback.calls, 16u) << "one grid has several parts";
    EXPECT_EQ(callback.freed, 0) << "blocks were freed during the call";
    EXPECT_LT(memory.live, before);
    if (!releases) rtcReleaseGeometry(callback.geometry);
  }
}

}} // namespace programs::test
