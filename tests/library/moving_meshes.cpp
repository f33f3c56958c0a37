// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Moving grids, quads and triangles match Embree's own kernels if vertices are on the lattice at all steps or stored
 * without loss, with every query and on every ISA. */

#include "support/filtered_geometry.h"
#include "support/irregular_mesh.h"
#include "support/memory.h"
#include "support/moving_surface.h"
#include "support/query_forms.h"
#include "support/same_hits.h"
#include "support/surface_access.h"

#include <gtest/gtest.h>

#include <set>

namespace programs::test { namespace {

constexpr double lattice = 0x1p-10;

// Rotates and bends.
Vec bentFreely(const Vec& p, unsigned step) {
  const double a = 0.3 * step, c = std::cos(a), s = std::sin(a);
  return {float(c * p[0] - s * p[1]), float(s * p[0] + c * p[1]), float(p[2] + 0.1 * step * p[0] * p[0])};
}

// The same, with positions that are multiples of the lattice.
Vec bent(const Vec& p, unsigned step) {
  Vec q = bentFreely(p, step);
  for (float& x : q) x = roundTo(x, lattice);
  return q;
}

template<typename Make, typename Mesh>
void expectEmbreesHits(const Device& device, const Make& make, const Mesh& mesh, Random& random, unsigned timeSteps) {
  Scene scenes[2] = {Scene(device), Scene(device)};
  for (int i = 0; i < 2; i++) {
    /* Otherwise, small grids with several steps are not compressed. */
    const unsigned flags = i ? RTC_COMPRESSION_FLAG_RELEASE_INPUT : RTC_COMPRESSION_FLAG_NONE;
    attach(scenes[i], make(device, mesh, i ? RTC_COMPRESSION_CVERT : RTC_COMPRESSION_NONE, flags, timeSteps));
    rtcCommitScene(scenes[i]);
  }
  const RTCCompressionStatistics stats = statisticsOf(scenes[1]);
  ASSERT_GT(stats.numMovingQuads, 0u);
  ASSERT_EQ(stats.numMovingQuads, stats.numQuads);
  ASSERT_EQ(stats.maxVertexDeviation, 0) << "all vertices are on the lattice";
  ASSERT_EQ(statisticsOf(scenes[0]).numQuads, 0u);
  std::vector<RTCRayHit> rays = raysAt(random, mesh, 400);
  for (RTCRayHit& r : rays) r.ray.time = float(random.uniform());
  size_t hits = 0;
  for (const RTCRayHit& ray : rays) hits += isHit(intersect(scenes[0], ray));
  ASSERT_GT(hits, 150u);
  expectSameQueries(scenes[0], scenes[1], rays, 2e-3, 1);
}

class MovingMeshes : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Isas, MovingMeshes, testing::Values(TEST_ISAS), nameOfIsa);

TEST_P(MovingMeshes, HitsMatchEmbree) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(3141);
  for (unsigned timeSteps : {2u, 4u}) {
    for (unsigned quads : {4u, 16u, 33u}) {
      SCOPED_TRACE(testing::Message() << "grids of " << quads << " quads a side, " << timeSteps << " steps");
      Diced diced = dicedSheet(quads < 16 ? 9 : 2, quads, lattice);
      diced.motion = bent;
      ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(device, newGrids, diced, random, timeSteps));
    }
    for (QuadOrder order : allQuadOrders) {
      SCOPED_TRACE(testing::Message() << "a mesh, " << nameOf(order) << ", " << timeSteps << " steps");
      DicedMesh mesh = meshOf(dicedSheet(2, 16, lattice), order, random);
      mesh.motion = bent;
      ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(device, newMesh, mesh, random, timeSteps));
      if (order != QuadOrder::Shuffled) {
        ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(device, newMesh, trianglesOf(mesh, 1, 2), random, timeSteps));
      }
    }
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST_P(MovingMeshes, LosslessHitsMatchEmbree) {
  Device device(GetParam() + std::string(",cbvh_max_error=0"));
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(3142);
  for (unsigned timeSteps : {2u, 5u}) {
    SCOPED_TRACE(testing::Message() << timeSteps << " steps");
    Diced diced = dicedSheet(2, 33);
    diced.motion = bentFreely;
    ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(device, newGrids, diced, random, timeSteps));
    DicedMesh mesh = meshOf(dicedSheet(2, 16), QuadOrder::Rows, random);
    mesh.motion = bentFreely;
    ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(device, newMesh, mesh, random, timeSteps));
    ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(device, newMesh, trianglesOf(mesh, 1, 2), random, timeSteps));
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST_P(MovingMeshes, IrregularHitsMatchEmbree) {
  for (const char* error : {"", ",cbvh_max_error=0"}) {
    Device device((GetParam() + std::string(error)).c_str());
    if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
    Random random(3146);
    for (NamedMesh& shape : irregularMeshes(random, lattice))
      for (unsigned timeSteps : {2u, 5u}) {
        SCOPED_TRACE(shape.name + ", " + std::to_string(timeSteps) + " steps" + error);
        shape.mesh.motion = *error ? bentFreely : bent;
        ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(device, newMesh, shape.mesh, random, timeSteps));
      }
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  }
}

// With filters, and in a moving instance.
template<typename Make, typename Mesh>
void expectFiltered(Device& device, const Make& make, const Mesh& mesh, Random& random) {
  std::vector<RTCRayHit> rays = raysAt(random, mesh, 503);
  for (RTCRayHit& r : rays) r.ray.time = float(random.uniform());
  const auto makeAs = [&](RTCCompression compression) { return make(device, mesh, compression, 0, 3); };
  expectSameFilteredHits(device, makeAs, true, rays, 2e-3, 2);
}

TEST_P(MovingMeshes, MasksFiltersAndInstances) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(3144);
  Diced grids = dicedSheet(4, 16, lattice);
  grids.motion = bent;
  ASSERT_NO_FATAL_FAILURE(expectFiltered(device, newGrids, grids, random));
  DicedMesh mesh = meshOf(grids, QuadOrder::Recursive, random);
  mesh.motion = bent;
  ASSERT_NO_FATAL_FAILURE(expectFiltered(device, newMesh, mesh, random));
  ASSERT_NO_FATAL_FAILURE(expectFiltered(device, newMesh, trianglesOf(mesh), random));
  for (DicedMesh irregular : {irregularTriangles(mesh, random), irregularQuads(mesh, random)}) {
    irregular.motion = bent;
    ASSERT_NO_FATAL_FAILURE(expectFiltered(device, newMesh, irregular, random));
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

std::vector<unsigned> verticesOf(const DicedMesh& mesh, unsigned primID) {
  if (mesh.isTriangleForm()) return {mesh.triangles[primID].begin(), mesh.triangles[primID].end()};
  return {mesh.quads[primID].begin(), mesh.quads[primID].end()};
}

std::vector<unsigned> verticesOf(const Diced& diced, unsigned primID) {
  const RTCGrid& grid = diced.grids[primID];
  std::vector<unsigned> vertices;
  for (unsigned y = 0; y < grid.height; y++)
    for (unsigned x = 0; x < grid.width; x++) vertices.push_back(grid.startVertexID + y * grid.stride + x);
  return vertices;
}

// Finds the nearest vertex at a time among the primitives that a query reports.
template<typename Mesh>
struct NearestVertex {
  const Mesh& mesh;
  float time;
  double distance = INFINITY;

  double distanceTo(unsigned vertex, const float p[3]) const {
    const Vec a = mesh.motion(mesh.vertices[vertex], 0), b = mesh.motion(mesh.vertices[vertex], 1);
    double d2 = 0;
    for (int k = 0; k < 3; k++) {
      const double d = (1 - time) * a[k] + time * b[k] - p[k];
      d2 += d * d;
    }
    return std::sqrt(d2);
  }

  static bool visit(RTCPointQueryFunctionArguments* args) {
    NearestVertex& self = *(NearestVertex*)args->userPtr;
    const float p[3] = {args->query->x, args->query->y, args->query->z};
    for (unsigned v : verticesOf(self.mesh, args->primID))
      self.distance = std::min(self.distance, self.distanceTo(v, p));
    if (self.distance >= args->query->radius) return false;
    args->query->radius = float(self.distance);
    return true;
  }
};

template<typename Make, typename Mesh>
void expectPointQueries(const Device& device, const Make& make, const Mesh& mesh, Random& random,
                        RTCCompression compression) {
  Scene scene(device);
  attach(scene, make(device, mesh, compression, 0, 2));
  rtcCommitScene(scene);
  ASSERT_GT(statisticsOf(scene).numMovingQuads, 0u);
  for (int i = 0; i < 100; i++) {
    NearestVertex<Mesh> nearest = {mesh, float(random.uniform())}, all = nearest;
    RTCPointQuery query = {float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), float(random.uniform(-0.5, 0.5)),
                           nearest.time, 1e9f};
    const float p[3] = {query.x, query.y, query.z};
    for (unsigned v = 0; v < mesh.vertices.size(); v++) all.distance = std::min(all.distance, all.distanceTo(v, p));
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, NearestVertex<Mesh>::visit, &nearest);
    // the distance to a quad is less than the distance to its vertices, by at most its diagonal
    ASSERT_NEAR(nearest.distance, all.distance, 0.1);
    ASSERT_GE(nearest.distance, all.distance);
  }
}

template<typename Make, typename Mesh>
void expectPointQueries(const Device& device, const Make& make, const Mesh& mesh, Random& random) {
  for (RTCCompression compression : {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE})
    ASSERT_NO_FATAL_FAILURE(expectPointQueries(device, make, mesh, random, compression));
}

TEST(MovingMeshesInTime, PointQueriesFindPositionsAtTheirTime) {
  Random random(3143);
  Device device;
  const DicedMotion motion = [](const Vec& p, unsigned step) { return step ? bent(p, 3) : p; };
  Diced grids = dicedSheet(2, 16, lattice);
  grids.motion = motion;
  ASSERT_NO_FATAL_FAILURE(expectPointQueries(device, newGrids, grids, random));
  DicedMesh mesh = meshOf(grids, QuadOrder::Recursive, random);
  mesh.motion = motion;
  ASSERT_NO_FATAL_FAILURE(expectPointQueries(device, newMesh, mesh, random));
  ASSERT_NO_FATAL_FAILURE(expectPointQueries(device, newMesh, trianglesOf(mesh, 1, 2), random));
  for (DicedMesh irregular : {irregularTriangles(mesh, random), irregularQuads(mesh, random)}) {
    irregular.motion = motion;
    ASSERT_NO_FATAL_FAILURE(expectPointQueries(device, newMesh, irregular, random));
  }
}

// A ball of grids whose copies of vertices move equally, and meshes with the same vertices.
TEST(MovingMeshesInTime, ClosedBallsDoNotLeak) {
  Random random(3142);
  Device device;
  Diced ball = dicedBall(3, 16, 2);
  ball.motion = [](const Vec& p, unsigned step) {
    return Vec{p[0] * (1 + 0.2f * step), p[1] + 0.1f * step * p[0], p[2] - 0.15f * step * p[1]};
  };
  std::vector<RTCGeometry> geometries = {newGrids(device, ball, RTC_COMPRESSION_CVERT, 0, 3)};
  for (QuadOrder order : allQuadOrders) {
    DicedMesh mesh = meshOf(ball, order, random);
    mesh.motion = ball.motion;
    geometries.push_back(newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, 3));
    if (order == QuadOrder::Shuffled) continue;
    const DicedMesh triangles = trianglesOf(mesh, 1, 1);
    const DicedMesh anyhow = unwelded(withTurnedTriangles(withShuffledFaces(triangles, random), random));
    for (const DicedMesh& of : {triangles, halvesApart(triangles), anyhow})
      geometries.push_back(newMesh(device, of, RTC_COMPRESSION_CVERT, 0, 3));
  }
  for (RTCGeometry geometry : geometries) {
    Scene scene(device);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    ASSERT_GT(statisticsOf(scene).numMovingQuads, 0u);
    size_t leaks = 0;
    for (const RTCRayHit& ray : raysAtMovingSurface(random, geometry, 12, 1000))
      leaks += !isHit(intersect(scene, ray)) || !occluded(scene, ray);
    EXPECT_EQ(leaks, 0u);
    rtcReleaseGeometry(geometry);
  }
}

// At any precision, welded or not.
TEST(MovingMeshesInTime, ClosedIrregularMeshesDoNotLeak) {
  Random random(3147);
  for (const char* config : {"", "cbvh_max_error=0", "cbvh_max_error=0.002", "cbvh_max_error=0.05"}) {
    Device device(config);
    const DicedMesh ball = jittered(meshOf(dicedBall(3, 16), QuadOrder::Rows, random), random, 0.005);
    const DicedMesh triangles = irregularTriangles(ball, random), quads = irregularQuads(ball, random);
    for (DicedMesh mesh : {triangles, quads, unwelded(triangles), unwelded(quads)}) {
      SCOPED_TRACE(std::string(config) + (mesh.isTriangleForm() ? ", triangles" : ", quads"));
      mesh.motion = [](const Vec& p, unsigned step) { return twisted(p, 0.3 * step); };
      RTCGeometry geometry = newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, 4);
      Scene scene(device);
      rtcAttachGeometry(scene, geometry);
      rtcCommitScene(scene);
      ASSERT_EQ(statisticsOf(scene).numIrregularQuads, statisticsOf(scene).numQuads);
      ASSERT_EQ(statisticsOf(scene).numMovingQuads, statisticsOf(scene).numQuads);
      EXPECT_GT(statisticsOf(scene).cacheBytesPerThread, size_t(1) << 16);
      EXPECT_LE(statisticsOf(scene).cacheBytesPerThread, cacheLimit()) << "no other cache is used";
      size_t leaks = 0;
      for (const RTCRayHit& ray : raysAtMovingSurface(random, geometry, 12, 2000))
        leaks += !isHit(intersect(scene, ray)) || !occluded(scene, ray);
      EXPECT_EQ(leaks, 0u);
      rtcReleaseGeometry(geometry);
    }
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  }
}

// A moving mesh is stored either in grids or in mesh blocks. Statistics count narrow grids as irregular, but rays do
// not use the cache of mesh blocks for them.
TEST(MovingMeshesInTime, NarrowGridsUseTheCacheOfGrids) {
  Random random(3190);
  Device device;
  size_t bytes[2];
  for (unsigned isNarrow : {0u, 1u}) {
    // a region has at most 64 quads per side
    DicedMesh mesh = meshOf(dicedSheet(1, 64 + isNarrow), QuadOrder::Rows, random);
    mesh.motion = bent;
    Scene scene(device);
    attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, 2));
    rtcCommitScene(scene);
    const RTCCompressionStatistics stats = statisticsOf(scene);
    ASSERT_EQ(stats.numMovingQuads, mesh.size());
    ASSERT_EQ(stats.numIrregularQuads > 0, isNarrow == 1);
    ASSERT_LT(stats.numIrregularQuads, stats.numQuads / 8);
    bytes[isNarrow] = stats.cacheBytesPerThread;
  }
  EXPECT_GT(bytes[0], size_t(1) << 16);
  EXPECT_EQ(bytes[0], bytes[1]);
}

// Vertices coincide at the first step and separate afterwards: a ray passes between the triangles.
TEST(MovingMeshesInTime, TrianglesThatSeparateAreNotConnected) {
  Random random(3148);
  Device device;
  DicedMesh mesh;
  for (int side : {-1, 1}) {
    Diced diced;
    diced.add(13, 13, [&](unsigned x, unsigned y) { return Vec{side * (float(x) / 12), 2 * float(y) / 12 - 1, 0}; });
    DicedMesh half = irregularTriangles(meshOf(diced, QuadOrder::Rows, random), random);
    for (auto& t : half.triangles)
      for (unsigned& v : t) v += unsigned(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), half.vertices.begin(), half.vertices.end());
    mesh.triangles.insert(mesh.triangles.end(), half.triangles.begin(), half.triangles.end());
  }
  std::vector<Vec> second = mesh.vertices;
  for (size_t i = 0; i < second.size(); i++) second[i][0] += i < second.size() / 2 ? -0.5f : 0.5f;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryTimeStepCount(geometry, 2);
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.vertices);
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, second);
  setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles);
  commitAs(geometry, RTC_COMPRESSION_CVERT, 0);
  Scene scene(device);
  attach(scene, geometry);
  rtcCommitScene(scene);
  ASSERT_EQ(statisticsOf(scene).numMovingQuads, mesh.size() / 2);
  for (float time : {0.0f, 0.25f, 1.0f})
    for (float x : {-0.1f, -0.01f, 0.01f, 0.1f, 0.3f}) {
      RTCRayHit ray = makeRay({x, 0.11f, 1}, {0, 0, -1});
      ray.ray.time = time;
      EXPECT_EQ(isHit(intersect(scene, ray)), std::fabs(x) >= 0.5f * time) << "time " << time << ", x " << x;
    }
}

// Time ranges inside of, around, and partly outside of the rays' times.
TEST(MovingMeshesInTime, IrregularMeshesExistInTheirTimeRange) {
  Random random(3149);
  Device device;
  DicedMesh mesh = irregularTriangles(meshOf(dicedSheet(1, 30, lattice), QuadOrder::Rows, random), random);
  mesh.motion = bent;
  for (const auto& range : {std::pair<float, float>{0.25f, 0.75f}, {-1.0f, 2.0f}, {0.5f, 3.0f}}) {
    Scene scenes[2] = {Scene(device), Scene(device)};
    for (int i = 0; i < 2; i++) {
      RTCGeometry geometry = newMesh(device, mesh, i ? RTC_COMPRESSION_CVERT : RTC_COMPRESSION_NONE, 0, 4);
      rtcSetGeometryTimeRange(geometry, range.first, range.second);
      rtcCommitGeometry(geometry);
      attach(scenes[i], geometry);
      rtcCommitScene(scenes[i]);
    }
    ASSERT_GT(statisticsOf(scenes[1]).numMovingQuads, 0u);
    size_t hits = 0, others = 0;
    for (int i = 0; i < 2000; i++) {
      RTCRayHit ray = rayAt(random, mesh);
      ray.ray.time = float(random.uniform());
      const RTCRayHit found = intersect(scenes[1], ray), expected = intersect(scenes[0], ray);
      hits += isHit(found);
      others += isHit(found) != isHit(expected) || found.hit.primID != expected.hit.primID;
      if (ray.ray.time < range.first || ray.ray.time > range.second) { ASSERT_FALSE(isHit(found)); }
    }
    EXPECT_GT(hits, 300u);
    EXPECT_LE(others, 3u);
  }
}

// Embree leaves out primitives with a vertex that is not finite at one of the steps, or that does not exist.
TEST(MovingMeshesInTime, InvalidIrregularPrimitivesAreLeftOut) {
  Random random(3150);
  Device device;
  const DicedMesh sheet = meshOf(dicedSheet(1, 30, lattice), QuadOrder::Rows, random);
  for (DicedMesh mesh : {irregularTriangles(sheet, random), irregularQuads(sheet, random)}) {
    std::vector<Vec> steps[3] = {mesh.vertices, mesh.vertices, mesh.vertices};
    for (int i = 0; i < 40; i++)
      steps[i % 3][random.below(unsigned(mesh.vertices.size()))][i % 2] = i % 4 ? NAN : INFINITY;
    for (int i = 0; i < 20; i++)
      if (mesh.isTriangleForm()) mesh.triangles[random.below(unsigned(mesh.size()))][i % 3] = 100000;
      else mesh.quads[random.below(unsigned(mesh.size()))][i % 4] = 100000;
    Scene scenes[2] = {Scene(device), Scene(device)};
    for (int i = 0; i < 2; i++) {
      RTCGeometry geometry =
          rtcNewGeometry(device, mesh.isTriangleForm() ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD);
      rtcSetGeometryTimeStepCount(geometry, 3);
      for (unsigned t = 0; t < 3; t++) setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, t, RTC_FORMAT_FLOAT3, steps[t]);
      if (mesh.isTriangleForm()) setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles);
      else setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, mesh.quads);
      commitAs(geometry, i ? RTC_COMPRESSION_CVERT : RTC_COMPRESSION_NONE, 0);
      attach(scenes[i], geometry);
      rtcCommitScene(scenes[i]);
    }
    ASSERT_GT(statisticsOf(scenes[1]).numMovingQuads, 0u);
    size_t hits = 0, misses = 0, others = 0;
    for (int i = 0; i < 3000; i++) {
      RTCRayHit ray = makeRay({float(random.uniform(-0.9, 0.9)), float(random.uniform(-0.9, 0.9)), 3}, {0, 0, -1});
      ray.ray.time = float(random.uniform());
      const RTCRayHit found = intersect(scenes[1], ray), expected = intersect(scenes[0], ray);
      hits += isHit(found);
      misses += !isHit(found);
      others += isHit(found) != isHit(expected) || found.hit.primID != expected.hit.primID;
    }
    EXPECT_GT(hits, 1000u);
    EXPECT_GT(misses, 100u);
    EXPECT_LE(others, 3u);
  }
}

TEST(MovingMeshesInTime, IrregularMeshesNeedFewBytes) {
  for (unsigned timeSteps : {2u, 5u}) {
    Memory memory;
    Device device;
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    Random random(3151);
    const DicedMesh quads = jittered(meshOf(dicedSheet(1, 200), QuadOrder::Rows, random), random, 0.002);
    DicedMesh mesh = irregularTriangles(quads, random, false);
    mesh.motion = bentFreely;
    Scene scene(device);
    const ssize_t empty = memory.live;
    RTCGeometry input = newMesh(device, mesh, RTC_COMPRESSION_NONE, 0, timeSteps);
    const ssize_t inputBytes = memory.live - empty;
    attach(scene, input);
    rtcCommitScene(scene);
    const double embree = double(memory.live - empty - inputBytes) / double(mesh.size());
    Scene compressed(device);
    const ssize_t before = memory.live;
    attach(compressed, newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, timeSteps));
    rtcCommitScene(compressed);
    const double bytes = double(memory.live - before - inputBytes) / double(mesh.size());
    const RTCCompressionStatistics stats = statisticsOf(compressed);
    const auto each = [&](size_t n) { return double(n) / double(mesh.size()); };
    std::printf("%u steps: %.2f bytes per triangle (%.2f tree, %.2f first step, %.2f per later step), Embree: %.2f\n",
                timeSteps, bytes, each(stats.topLevelBytes),
                each(stats.headerBytes + stats.nodeBytes + stats.leafBytes - stats.motionBytes),
                each(stats.motionBytes) / (timeSteps - 1), embree);
    EXPECT_LE(each(stats.motionBytes) / (timeSteps - 1), 3.0);
    EXPECT_LT(bytes, 0.5 * embree);
  }
}

// The triangle's vertices lie between their positions at the steps, and its plane contains the hit.
TEST(MovingMeshesInTime, TrianglesOfHitsAreReported) {
  Random random(3145);
  Device device;
  for (QuadOrder order : allQuadOrders) {
    DicedMesh quads = meshOf(dicedSheet(3, 16, lattice), order, random);
    quads.motion = bent;
    for (const DicedMesh& mesh :
         {quads, trianglesOf(quads, 2, 1), irregularTriangles(quads, random), irregularQuads(quads, random)}) {
      Scene scene(device);
      RTCGeometry geometry = newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, 2);
      attach(scene, geometry);
      rtcCommitScene(scene);
      ASSERT_GT(statisticsOf(scene).numMovingQuads, 0u);
      size_t hits = 0;
      for (int i = 0; i < 500; i++) {
        RTCRayHit ray = rayAt(random, mesh);
        ray.ray.time = float(random.uniform());
        const RTCRayHit r = intersect(scene, ray);
        if (!isHit(r)) continue;
        hits++;
        CbvhTriangle t;
        ASSERT_TRUE(findStoredTriangle(geometry, ray.ray.time, r.hit.primID, r.hit.u, r.hit.v, &r.hit.Ng_x, &t));
        std::set<unsigned> corners;
        for (unsigned v : verticesOf(mesh, r.hit.primID)) corners.insert(v);
        for (int c = 0; c < 3; c++) {
          // one of the primitive's vertices, between its two positions
          bool isVertex = false;
          for (unsigned v : corners) {
            const Vec a = bent(mesh.vertices[v], 0), b = bent(mesh.vertices[v], 1);
            bool isThis = true;
            for (int k = 0; k < 3; k++)
              isThis &= std::fabs((1 - ray.ray.time) * a[k] + ray.ray.time * b[k] - t.vertices[c][k]) < 1e-6f;
            if (isThis) {
              isVertex = true;
              corners.erase(v);
              break;
            }
          }
          ASSERT_TRUE(isVertex) << "vertex " << c;
        }
        double height = 0, n = 0;
        for (int k = 0; k < 3; k++) {
          const float Ng[3] = {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}, o[3] = {r.ray.org_x, r.ray.org_y, r.ray.org_z},
                      d[3] = {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z};
          height += Ng[k] * (o[k] + double(r.ray.tfar) * d[k] - t.vertices[0][k]);
          n += double(Ng[k]) * Ng[k];
        }
        ASSERT_LT(std::fabs(height), 1e-5 * std::sqrt(n));
      }
      EXPECT_GT(hits, 150u);
    }
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(MovingMeshesInTime, GridsThatSeparateAreNotConnected) {
  Device device;
  Diced diced;
  for (int side : {-1, 1})
    diced.add(17, 17, [&](unsigned x, unsigned y) { return Vec{side * (float(x) / 16), 2 * float(y) / 16 - 1, 0}; });
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
  rtcSetGeometryTimeStepCount(geometry, 2);
  std::vector<Vec> second = diced.vertices;
  for (size_t i = 0; i < second.size(); i++) second[i][0] += i < 17 * 17 ? -0.5f : 0.5f;
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, diced.vertices);
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, second);
  setBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, diced.grids);
  commitAs(geometry, RTC_COMPRESSION_CVERT, 0);
  Scene scene(device);
  attach(scene, geometry);
  rtcCommitScene(scene);
  for (float time : {0.0f, 0.25f, 1.0f})
    for (float x : {-0.1f, -0.01f, 0.0f, 0.01f, 0.1f, 0.3f}) {
      RTCRayHit ray = makeRay({x, 0.11f, 1}, {0, 0, -1});
      ray.ray.time = time;
      EXPECT_EQ(isHit(intersect(scene, ray)), std::fabs(x) >= 0.5f * time) << "time " << time << ", x " << x;
    }
}

}} // namespace programs::test
