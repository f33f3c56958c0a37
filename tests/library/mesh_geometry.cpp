// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compressed meshes of quads and triangles: the library finds grids in them, and hits match Embree's own kernels, in
 * any order of the quads. */

#include "support/closed.h"
#include "support/irregular_mesh.h"
#include "support/filtered_geometry.h"
#include "support/memory.h"
#include "support/same_hits.h"
#include "support/stitched_mesh.h"
#include "support/surface_access.h"

#include <chrono>
#include <cstdio>
#include <mutex>
#include <set>

namespace programs::test { namespace {

const double lattice = 0x1p-10;
const double slack = 1e-3; // of parameters: quads are small, and Embree's floats are less accurate than on a grid

class MeshGeometry : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Isas, MeshGeometry, testing::Values(TEST_ISAS), nameOfIsa);

struct Shape {
  std::string name;
  DicedMesh mesh;
};

// Meshes whose vertices are on the lattice, so that triangles are the same with and without compression.
std::vector<Shape> shapes(Random& random) {
  std::vector<Shape> all;
  for (QuadOrder order : allQuadOrders) {
    all.push_back(
        {std::string("patches of 8 quads a side, ") + nameOf(order), meshOf(dicedSheet(4, 8, lattice), order, random)});
    all.push_back({std::string("patches of 32 quads a side, ") + nameOf(order),
                   meshOf(dicedSheet(2, 32, lattice), order, random)});
  }
  all.push_back(
      {"patches of 11 quads a side, row by row", meshOf(dicedSheet(3, 11, lattice), QuadOrder::Rows, random)});
  all.push_back(
      {"one sheet of 100 quads a side, row by row", meshOf(dicedSheet(1, 100, lattice), QuadOrder::Rows, random)});
  DicedMesh ball = meshOf(dicedBall(2, 16), QuadOrder::Recursive, random), earth = globe(60, 40);
  for (DicedMesh* mesh : {&ball, &earth})
    for (Vec& p : mesh->vertices)
      for (float& x : p) x = roundTo(x, lattice);
  all.push_back({"a ball of patches that begin at any of their corners", ball});
  all.push_back({"a globe with poles", earth});
  return all;
}

void expectEmbreesHits(const Device& device, const DicedMesh& mesh, Random& random, unsigned count) {
  const MeshScene embree(device, mesh, RTC_COMPRESSION_NONE), scene(device, mesh);
  const RTCCompressionStatistics stats = statisticsOf(scene);
  ASSERT_EQ(stats.numQuads, mesh.isTriangleForm() ? mesh.size() / 2 : mesh.size());
  ASSERT_EQ(stats.numMeshQuads, stats.numQuads);
  ASSERT_EQ(stats.maxVertexDeviation, 0) << "all vertices are on the lattice";
  ASSERT_EQ(statisticsOf(embree).numQuads, 0u);
  expectSameQueries(embree, scene, raysAt(random, mesh, count), slack);
}

TEST_P(MeshGeometry, HitsOfQuadsMatchEmbree) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(121);
  for (const Shape& shape : shapes(random)) {
    SCOPED_TRACE(shape.name);
    expectEmbreesHits(device, shape.mesh, random, 1003);
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST_P(MeshGeometry, HitsOfTrianglesMatchEmbree) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(122);
  for (const Shape& shape : shapes(random)) {
    const unsigned first = random.below(3), second = random.below(3);
    SCOPED_TRACE(testing::Message() << shape.name << ", first corners " << first << " and " << second);
    expectEmbreesHits(device, trianglesOf(shape.mesh, first, second), random, 1003);
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// The triangles of a quad are anywhere in the index buffer, begin at any corner, and may share vertices or not.
TEST_P(MeshGeometry, HitsOfTrianglesInAnyOrderMatchEmbree) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(136);
  const DicedMesh rows = meshOf(dicedSheet(2, 32, lattice), QuadOrder::Rows, random);
  for (const OrderedMesh& ordered : trianglesInAnyOrder(rows, random)) {
    SCOPED_TRACE(ordered.name);
    expectEmbreesHits(device, ordered.mesh, random, 503);
    if (HasFatalFailure()) return;
  }
  const DicedMesh quads = meshOf(dicedSheet(3, 16, lattice), QuadOrder::Recursive, random);
  for (const DicedMesh& mesh : {unwelded(quads), unwelded(withShuffledFaces(quads, random))}) {
    expectEmbreesHits(device, mesh, random, 503);
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// Patches of adaptive subdivision, with patches that are triangles, vertices in random order, and collapsed edges.
TEST_P(MeshGeometry, HitsOfStitchedPatchesMatchEmbree) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(142);
  StitchedSheet sheet;
  sheet.lattice = lattice;
  for (const std::array<unsigned, 2>& rates : {std::array<unsigned, 2>{2, 6}, {8, 8}, {2, 64}, {12, 20}})
    for (double part : {0.0, 0.3}) {
      SCOPED_TRACE(testing::Message() << "rates " << rates[0] << " to " << rates[1] << ", triangular part " << part);
      sheet.minRate = rates[0];
      sheet.maxRate = rates[1];
      sheet.columns = sheet.rows = 1 + 120 / (rates[0] + rates[1]);
      sheet.triangular = part;
      sheet.collapsed = part / 10;
      DicedMesh mesh = stitchedMesh(sheet, random);
      if (part > 0) mesh = withShuffledVertices(mesh, random);
      const MeshScene embree(device, mesh, RTC_COMPRESSION_NONE), scene(device, mesh);
      ASSERT_GT(statisticsOf(scene).numMeshQuads, 0u);
      ASSERT_EQ(statisticsOf(scene).maxVertexDeviation, 0) << "all vertices are on the lattice";
      expectSameQueries(embree, scene, raysAt(random, mesh, 503), slack, 2); // Embree misses some at edges
      if (HasFatalFailure()) return;
    }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// Single triangles between pairs: pairs after them begin with an odd number.
TEST_P(MeshGeometry, HitsNextToSingleTrianglesMatchEmbree) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(123);
  DicedMesh mesh = trianglesOf(meshOf(dicedSheet(3, 16, lattice), QuadOrder::Rows, random), 1, 2);
  for (unsigned i = 0; i < 9; i++) {
    const unsigned v = unsigned(mesh.vertices.size());
    for (const Vec& p : {Vec{1.5f, 0, 0}, Vec{1.75f, 0, 0.25f}, Vec{1.5f, 0.25f, 0}})
      mesh.vertices.push_back({p[0], p[1] + 0.25f * float(i), p[2]});
    mesh.triangles.insert(mesh.triangles.begin() + i * 73, {v, v + 1, v + 2});
  }
  const MeshScene embree(device, mesh, RTC_COMPRESSION_NONE), scene(device, mesh);
  ASSERT_EQ(statisticsOf(scene).numQuads, 48u * 48 + 5);
  EXPECT_EQ(statisticsOf(scene).numIrregularQuads, 5u) << "two triangles count as a quad";
  expectSameQueries(embree, scene, raysAt(random, mesh, 2000), slack);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST_P(MeshGeometry, MasksFiltersAndInstances) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(124);
  const DicedMesh sheet = meshOf(dicedSheet(4, 16, lattice), QuadOrder::Recursive, random);
  for (const DicedMesh& mesh : {sheet, trianglesOf(sheet)}) {
    const auto make = [&](RTCCompression compression) { return newMesh(device, mesh, compression); };
    ASSERT_NO_FATAL_FAILURE(expectSameFilteredHits(device, make, false, raysAt(random, mesh, 503), slack));
  }
}

// --- closed -----------------------------------------------------------------------------------

TEST(Meshes, AreClosedBetweenRegions) {
  Device device;
  Random random(125);
  Shape balls[] = {{"patches of 4 quads", meshOf(dicedBall(3, 4), QuadOrder::Recursive, random)},
                   {"patches of 16 quads", meshOf(dicedBall(4, 16), QuadOrder::Rows, random)},
                   {"shuffled", meshOf(dicedBall(3, 12), QuadOrder::Shuffled, random)},
                   {"quads of very different size", meshOf(dicedBall(8, 5, 3), QuadOrder::Rows, random)},
                   {"globe", globe(90, 50)}};
  for (const Shape& ball : balls)
    for (const DicedMesh& mesh : {ball.mesh, trianglesOf(ball.mesh, 1, 1)}) {
      SCOPED_TRACE(testing::Message() << ball.name << (mesh.isTriangleForm() ? ", triangles" : ""));
      const MeshScene scene(device, mesh);
      ASSERT_GT(statisticsOf(scene).maxVertexDeviation, 0);
      std::vector<RTCRayHit> rays;
      for (unsigned i = 0; i < 30000; i++) {
        const auto& q = ball.mesh.quads[random.below(unsigned(ball.mesh.quads.size()))];
        const unsigned k = random.below(4);
        const Vec &a = mesh.vertices[q[k]], &b = mesh.vertices[q[(k + 1) % 4]];
        rays.push_back(rayFromMiddle(random, a, b));
      }
      expectNoneMisses(scene, rays);
    }
}

// --- regular parts ----------------------------------------------------------------------------

TEST(Meshes, RegularPartsAreFoundInAnyOrder) {
  Device device("cbvh_max_error=0.00043"); // 1/36 of an edge of the sheet
  Random random(126);
  for (QuadOrder order : allQuadOrders) {
    SCOPED_TRACE(nameOf(order));
    const DicedMesh sheet = meshOf(dicedSheet(4, 32), order, random), ball = meshOf(dicedBall(2, 16), order, random);
    for (const DicedMesh& mesh : {sheet, ball, trianglesOf(sheet), trianglesOf(ball, 2, 1)}) {
      const MeshScene scene(device, mesh);
      const RTCCompressionStatistics stats = statisticsOf(scene);
      const size_t quads = mesh.isTriangleForm() ? mesh.size() / 2 : mesh.size();
      EXPECT_EQ(stats.numMeshQuads, quads);
      EXPECT_EQ(stats.numIrregularQuads, 0u);
      EXPECT_LE(stats.numBlocks, quads / 256 + quads / 512) << "blocks are full";
      // numbers in a pattern take 8 bytes per block; otherwise each quad needs as many bits as their range
      EXPECT_LE(double(stats.leafBytes) / double(quads), order == QuadOrder::Shuffled ? 5.5 : 3.5);
    }
  }
  const DicedMesh earth = globe(100, 60);
  const MeshScene scene(device, earth);
  EXPECT_EQ(statisticsOf(scene).numMeshQuads, earth.size());
  EXPECT_LE(statisticsOf(scene).numIrregularQuads, 200u) << "at the poles";
}

// Blocks are full, and numbers in a pattern need few bytes. Where patches of a ball meet, pairs of triangles that
// resemble quads may continue into the next patch.
TEST(Meshes, RegularTrianglesAreFoundInAnyOrder) {
  Device device("cbvh_max_error=0.00043"); // 1/36 of an edge of the sheet
  Random random(137);
  const DicedMesh sheet = meshOf(dicedSheet(4, 32), QuadOrder::Rows, random);
  const DicedMesh ball = meshOf(dicedBall(2, 16), QuadOrder::Recursive, random);
  for (bool isSheet : {true, false})
    for (const OrderedMesh& ordered : trianglesInAnyOrder(isSheet ? sheet : ball, random)) {
      SCOPED_TRACE(testing::Message() << ordered.name << (isSheet ? ", a sheet" : ", a ball"));
      const MeshScene scene(device, ordered.mesh);
      const RTCCompressionStatistics stats = statisticsOf(scene);
      const size_t quads = (isSheet ? sheet : ball).quads.size();
      const auto is = [&](const char* word) { return ordered.name.find(word) != std::string::npos; };
      const bool hasPattern = !is("shuffled") && !is("turned");
      const bool isCertain = isSheet || hasPattern;
      ASSERT_GE(stats.numMeshQuads, quads);
      EXPECT_LE(stats.numMeshQuads, isCertain ? quads : quads + quads / 50);
      EXPECT_LE(stats.numIrregularQuads, isCertain ? 0 : quads / 20);
      EXPECT_LE(stats.numBlocks, isCertain ? quads / 256 + quads / 128 : quads / 32);
      EXPECT_LE(double(stats.leafBytes) / double(quads), hasPattern ? 3.5 : isSheet ? 7.5 : 9.5);
    }
}

// Strips of quads whose triangles are in random order: in narrow ones grids would save little, and slow rays.
TEST(Meshes, TrianglesOfNarrowStripsAreIrregular) {
  Device device;
  Random random(139);
  for (unsigned width : {3u, 4u, 16u}) {
    DicedMesh strips;
    for (unsigned strip = 0; strip < 8; strip++) {
      const unsigned first = unsigned(strips.vertices.size()), length = 64, row = width + 1;
      for (unsigned i = 0; i < row * (length + 1); i++)
        strips.vertices.push_back({float(i % row), float(i / row), float(2 * strip) + 0.1f * float(i % row * (i % 7))});
      for (unsigned i = 0; i < row * length; i++)
        if (i % row < width) strips.quads.push_back({first + i, first + i + 1, first + i + row + 1, first + i + row});
    }
    DicedMesh triangles = trianglesOf(strips);
    for (size_t i = triangles.triangles.size(); i-- > 1;)
      std::swap(triangles.triangles[i], triangles.triangles[random.below(unsigned(i + 1))]);
    const RTCCompressionStatistics stats = statisticsOf(MeshScene(device, triangles));
    EXPECT_EQ(stats.numIrregularQuads, width < 16 ? strips.quads.size() : 0) << width << " quads wide";
  }
}

// Adaptive subdivision: small grids between stitched borders are not worth a search, large ones are.
TEST(Meshes, GridsOfStitchedPatchesAreUsedIfTheyAreLarge) {
  Device device;
  Random random(143);
  StitchedSheet sheet;
  for (bool areLarge : {false, true})
    for (bool isShuffled : {false, true}) {
      SCOPED_TRACE(testing::Message() << (areLarge ? "large" : "small") << (isShuffled ? ", vertices shuffled" : ""));
      sheet.minRate = areLarge ? 16 : 4;
      sheet.maxRate = areLarge ? 32 : 8;
      sheet.columns = sheet.rows = areLarge ? 8 : 25;
      const DicedMesh mesh = stitchedMesh(sheet, random);
      const RTCCompressionStatistics stats =
          statisticsOf(MeshScene(device, isShuffled ? withShuffledVertices(mesh, random) : mesh));
      const double quads = double(stats.numQuads),
                   bytes = double(stats.topLevelBytes + stats.headerBytes + stats.nodeBytes + stats.leafBytes);
      ASSERT_GE(stats.numQuads, mesh.triangles.size() / 2);
      if (areLarge) {
        EXPECT_LE(double(stats.numIrregularQuads), 0.2 * quads);
        EXPECT_LE(bytes, 8 * quads);
      } else {
        EXPECT_EQ(stats.numIrregularQuads, stats.numQuads);
        EXPECT_LE(bytes, 14 * quads);
      }
    }
}

// Each quad along some rows of a sheet has two vertices of its own, as in a mesh that is smooth except at sharp edges.
TEST(Meshes, SplitEdgesDoNotIncreaseMemory) {
  Device device;
  Random random(138);
  const DicedMesh whole = meshOf(dicedSheet(1, 96), QuadOrder::Rows, random);
  DicedMesh split = whole;
  for (size_t i = 0; i < split.quads.size(); i++)
    if (i / 96 % 7 == 3)
      for (unsigned k = 0; k < 2; k++) {
        split.vertices.push_back(whole.vertices[split.quads[i][k]]);
        split.quads[i][k] = unsigned(split.vertices.size() - 1);
      }
  for (bool asTriangles : {false, true}) {
    const auto statistics = [&](const DicedMesh& mesh) {
      return statisticsOf(MeshScene(device, asTriangles ? trianglesOf(mesh) : mesh));
    };
    const RTCCompressionStatistics a = statistics(whole), b = statistics(split);
    EXPECT_EQ(a.numBlocks, b.numBlocks);
    EXPECT_EQ(a.leafBytes, b.leafBytes);
    EXPECT_EQ(a.numMeshQuads, b.numMeshQuads);
  }
}

TEST(Meshes, VerticesThatSeparateAreNotWelded) {
  Device device;
  Random random(139);
  DicedMesh mesh;
  for (int side : {-1, 1}) {
    const unsigned first = unsigned(mesh.vertices.size());
    for (unsigned y = 0; y <= 32; y++)
      for (unsigned x = 0; x <= 32; x++)
        mesh.vertices.push_back({float(side) * float(side > 0 ? x : 32 - x) / 32, float(y) / 16 - 1, 0});
    for (unsigned y = 0; y < 32; y++)
      for (unsigned x = 0; x < 32; x++) {
        const unsigned v = first + y * 33 + x;
        mesh.quads.push_back({v, v + 1, v + 34, v + 33});
      }
  }
  for (bool asTriangles : {false, true}) {
    const DicedMesh both = asTriangles ? trianglesOf(mesh) : mesh;
    std::vector<Vec> second = both.vertices;
    for (size_t i = 0; i < second.size(); i++) second[i][0] += i < second.size() / 2 ? -0.5f : 0.5f;
    RTCGeometry geometry = rtcNewGeometry(device, asTriangles ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD);
    rtcSetGeometryTimeStepCount(geometry, 2);
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, both.vertices);
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, second);
    if (asTriangles) setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, both.triangles);
    else setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, both.quads);
    commitAs(geometry, RTC_COMPRESSION_CVERT, 0);
    Scene scene(device);
    attach(scene, geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(statisticsOf(scene).numMeshQuads, 2048u);
    for (float time : {0.0f, 1.0f})
      for (float x : {-0.3f, 0.0f, 0.3f}) {
        RTCRayHit ray = makeRay({x + 0.001f, 0.01f, 1}, {0, 0, -1});
        ray.ray.time = time;
        EXPECT_EQ(isHit(intersect(scene, ray)), time == 0) << "at " << x << " and time " << time;
      }
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// Quads with different diagonals do not form a grid, which has the same diagonal everywhere.
TEST(Meshes, MixedDiagonalsKeepTheirTriangles) {
  Device device;
  Random random(140);
  for (double part : {0.02, 0.5}) {
    DicedMesh quads = meshOf(dicedSheet(2, 32, lattice), QuadOrder::Rows, random);
    for (auto& q : quads.quads)
      if (random.chance(part)) std::rotate(q.begin(), q.begin() + 1, q.end());
    for (const OrderedMesh& ordered : trianglesInAnyOrder(quads, random)) {
      SCOPED_TRACE(testing::Message() << ordered.name << ", other diagonals: " << part);
      const MeshScene embree(device, ordered.mesh, RTC_COMPRESSION_NONE), scene(device, ordered.mesh);
      const std::vector<RTCRayHit> rays = raysAt(random, ordered.mesh, 503);
      expectSameHits(closestHits(embree, rays, QueryForm::Single), closestHits(scene, rays, QueryForm::Single), slack);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// A closed mesh has no corner to begin at.
TEST(Meshes, ClosedMeshesAreFoundFromAnyQuad) {
  Device device;
  Random random(141);
  const DicedMesh natural = globe(400, 200);
  DicedMesh reversed = natural;
  std::reverse(reversed.quads.begin(), reversed.quads.end());
  const auto secondsToFind = [&](const DicedMesh& mesh, RTCCompression compression) {
    double least = INFINITY;
    for (int i = 0; i < 5; i++) {
      RTCGeometry geometry = newMesh(device, mesh, RTC_COMPRESSION_NONE);
      RTCCompressionArguments args;
      rtcInitCompressionArguments(&args);
      args.compression = compression;
      rtcSetGeometryCompression(geometry, &args);
      const auto begin = std::chrono::steady_clock::now();
      rtcCommitGeometry(geometry);
      least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
      rtcReleaseGeometry(geometry);
    }
    return least;
  };
  const RTCCompressionStatistics expected = statisticsOf(MeshScene(device, natural));
  const double expectedTime = secondsToFind(natural, RTC_COMPRESSION_CVERT);
  for (const DicedMesh& mesh : {reversed, withShuffledFaces(natural, random)}) {
    const RTCCompressionStatistics stats = statisticsOf(MeshScene(device, mesh));
    EXPECT_EQ(stats.numMeshQuads, natural.quads.size());
    EXPECT_LE(stats.numIrregularQuads, expected.numIrregularQuads + 400);
    EXPECT_LE(double(stats.numBlocks), 1.1 * double(expected.numBlocks));
    EXPECT_LT(secondsToFind(mesh, RTC_COMPRESSION_CVERT), 6 * expectedTime);
  }
}

// Also quads that share no vertices, and moving meshes. Small meshes and refitted ones are left to Embree.
TEST(Meshes, IrregularMeshesBecomeMeshBlocks) {
  Device device;
  Random random(127);
  DicedMesh heap;
  for (int i = 0; i < 2000; i++)
    heap.vertices.push_back({float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), float(random.uniform(-1, 1))});
  DicedMesh triangles = heap;
  for (int i = 0; i < 4000; i++) {
    std::array<unsigned, 4> q;
    for (unsigned& v : q) v = random.below(2000);
    heap.quads.push_back(q);
    triangles.triangles.push_back({q[0], q[1], q[2]});
  }
  DicedMesh apart; // no quad shares a vertex or a position with another
  const DicedMesh sheet = meshOf(dicedSheet(2, 32), QuadOrder::Rows, random);
  for (const auto& q : sheet.quads) {
    const unsigned v = unsigned(apart.vertices.size());
    for (unsigned k : q) {
      apart.vertices.push_back(sheet.vertices[k]);
      apart.vertices.back()[2] += 1e-4f * float(apart.quads.size() % 7);
    }
    apart.quads.push_back({v, v + 1, v + 2, v + 3});
  }
  DicedMesh one = sheet;
  one.quads.resize(1);
  for (const DicedMesh& mesh : {heap, triangles, apart, one})
    for (unsigned timeSteps : {1u, 2u}) {
      Scene scene(device);
      attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, timeSteps));
      rtcCommitScene(scene);
      EXPECT_EQ(statisticsOf(scene).numIrregularQuads > 0, mesh.size() > 1);
      EXPECT_EQ(statisticsOf(scene).numIrregularQuads, statisticsOf(scene).numQuads);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      EXPECT_TRUE(isHit(intersect(scene, rayAt(random, mesh))));
    }
  Scene refitted(device);
  RTCGeometry geometry = newMesh(device, sheet, RTC_COMPRESSION_CVERT);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
  rtcCommitGeometry(geometry);
  attach(refitted, geometry);
  rtcCommitScene(refitted);
  EXPECT_EQ(statisticsOf(refitted).numQuads, 0u);
  EXPECT_TRUE(isHit(intersect(refitted, rayAt(random, sheet))));
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// The triangles of a quad are tested separately.
TEST(Meshes, PointQueriesFindTheTriangleNextToANonFiniteOne) {
  Device device;
  Random random(135);
  DicedMesh mesh = trianglesOf(meshOf(dicedSheet(1, 32, lattice), QuadOrder::Rows, random));
  const unsigned pair = 500; // only its second triangle gets its own vertex
  mesh.triangles[2 * pair + 1][0] = unsigned(mesh.vertices.size());
  mesh.vertices.push_back({NAN, 0, 0});
  const MeshScene scene(device, mesh);
  ASSERT_EQ(statisticsOf(scene).numMeshQuads, 1024u);
  const Vec &a = mesh.vertices[mesh.triangles[2 * pair][0]], &b = mesh.vertices[mesh.triangles[2 * pair][1]],
            &c = mesh.vertices[mesh.triangles[2 * pair][2]];
  RTCPointQuery query;
  query.x = (a[0] + b[0] + c[0]) / 3;
  query.y = (a[1] + b[1] + c[1]) / 3;
  query.z = (a[2] + b[2] + c[2]) / 3;
  query.time = 0;
  query.radius = 1e-3f;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  std::set<unsigned> near;
  rtcPointQuery(
      scene, &query, &context,
      [](RTCPointQueryFunctionArguments* args) {
        ((std::set<unsigned>*)args->userPtr)->insert(args->primID);
        return false;
      },
      &near);
  EXPECT_TRUE(near.count(2 * pair));
  EXPECT_FALSE(near.count(2 * pair + 1));
}

// Invalid indices, and vertices that are not finite, as in Embree.
TEST(Meshes, InvalidPrimitivesAreLeftOut) {
  Device device;
  Random random(128);
  const DicedMesh good = meshOf(dicedSheet(2, 32, lattice), QuadOrder::Rows, random);
  DicedMesh bad = good;
  for (int i = 0; i < 20; i++)
    bad.quads[random.below(unsigned(bad.size()))][random.below(4)] = i % 2 ? ~0u : unsigned(bad.vertices.size());
  for (int i = 0; i < 20; i++)
    bad.vertices[random.below(unsigned(bad.vertices.size()))][i % 3] = i % 2 ? INFINITY : NAN;
  DicedMesh badTriangles = trianglesOf(bad);
  for (const DicedMesh& mesh : {bad, badTriangles}) {
    const MeshScene embree(device, mesh, RTC_COMPRESSION_NONE), scene(device, mesh);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_GT(statisticsOf(scene).numMeshQuads, 3900u);
    const std::vector<RTCRayHit> rays = raysAt(random, good, 3000);
    unsigned other = 0;
    const std::vector<RTCRayHit> expected = closestHits(embree, rays, QueryForm::Single),
                                 found = closestHits(scene, rays, QueryForm::Single);
    const auto isFinite = [&](unsigned v) {
      return std::isfinite(mesh.vertices[v][0] + mesh.vertices[v][1] + mesh.vertices[v][2]);
    };
    for (size_t i = 0; i < rays.size(); i++) {
      if (expected[i].hit.primID == found[i].hit.primID) continue;
      // Embree leaves out both triangles of a quad if a vertex of either is not finite.
      if (!mesh.isTriangleForm() && isHit(found[i]) &&
          !std::all_of(mesh.quads[found[i].hit.primID].begin(), mesh.quads[found[i].hit.primID].end(), isFinite))
        continue;
      other++;
    }
    EXPECT_EQ(other, 0u);
  }
}

// In meshes that are stored in grids, in mesh blocks, and in both.
TEST(Meshes, InvalidIndicesAreCounted) {
  Device device;
  Random random(129);
  const DicedMesh sheet = meshOf(dicedSheet(1, 64, lattice), QuadOrder::Rows, random);
  for (DicedMesh mesh : {sheet, trianglesOf(sheet), irregularQuads(sheet, random), irregularTriangles(sheet, random),
                         partlyIrregular(sheet, random, false), partlyIrregular(sheet, random, true)}) {
    for (unsigned i = 0; i < 10; i++)
      if (mesh.isTriangleForm()) mesh.triangles[300 * i][i % 3] = unsigned(mesh.vertices.size());
      else mesh.quads[300 * i][i % 4] = ~0u;
    for (unsigned timeSteps : {1u, 2u}) {
      Scene scene(device);
      attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, timeSteps));
      rtcCommitScene(scene);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      EXPECT_EQ(statisticsOf(scene).numInvalidQuads, mesh.isTriangleForm() ? 5u : 10u);
    }
  }
}

// --- settings ---------------------------------------------------------------------------------

TEST(Meshes, CompressionCanBeSelected) {
  Random random(129);
  const DicedMesh quads = meshOf(dicedSheet(2, 32), QuadOrder::Recursive, random), triangles = trianglesOf(quads);
  const auto count = [&](const Device& device, const DicedMesh& mesh, RTCCompression compression) {
    const MeshScene scene(device, mesh, compression);
    return statisticsOf(scene).numQuads;
  };
  Device plain, ofString("subdiv_accel=cbvh"), noQuads("subdiv_accel=cbvh.vert,cbvh_quads=0"),
      noTriangles("subdiv_accel=cbvh.leaf,cbvh_triangles=0");
  for (const DicedMesh& mesh : {quads, triangles}) {
    EXPECT_EQ(count(plain, mesh, RTC_COMPRESSION_INHERIT), 0u);
    EXPECT_EQ(count(plain, mesh, RTC_COMPRESSION_CLEAF), 4096u) << "diced geometry is stored as cVERT";
    EXPECT_EQ(count(ofString, mesh, RTC_COMPRESSION_INHERIT), 4096u);
    EXPECT_EQ(count(ofString, mesh, RTC_COMPRESSION_NONE), 0u);
    EXPECT_EQ(count(noQuads, mesh, RTC_COMPRESSION_INHERIT), mesh.isTriangleForm() ? 4096u : 0u);
    EXPECT_EQ(count(noTriangles, mesh, RTC_COMPRESSION_INHERIT), mesh.isTriangleForm() ? 0u : 4096u);
    EXPECT_EQ(count(noQuads, mesh, RTC_COMPRESSION_CVERT), 4096u) << "the geometry's own setting";
  }
  EXPECT_EQ(plain.takeError(), RTC_ERROR_NONE) << plain.message;
}

TEST(Meshes, ReleaseInputAfterEdits) {
  Device device;
  Random random(130);
  const DicedMesh quads = meshOf(dicedSheet(4, 32), QuadOrder::Recursive, random);
  for (const DicedMesh& mesh : {quads, trianglesOf(quads)}) {
    const RTCRayHit down = makeRay({0.3f, 0.2f, 5}, {0, 0, -1});
    Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
    RTCGeometry geometry = newMesh(device, mesh, RTC_COMPRESSION_CVERT);
    attach(scene, geometry);
    rtcCommitScene(scene);
    const RTCRayHit before = intersect(scene, down);
    ASSERT_TRUE(isHit(before));
    float* x = (float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    for (size_t i = 0; i < mesh.vertices.size(); i++) x[3 * i + 2] -= 1;
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    EXPECT_NEAR(intersect(scene, down).ray.tfar, before.ray.tfar + 1, 1e-3);
    rtcDisableGeometry(geometry);
    rtcCommitScene(scene);
    EXPECT_FALSE(isHit(intersect(scene, down)));
    rtcEnableGeometry(geometry);
    for (RTCCompression compression : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CVERT}) {
      RTCCompressionArguments args;
      rtcInitCompressionArguments(&args);
      args.compression = compression;
      if (compression == RTC_COMPRESSION_CVERT) args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
      rtcSetGeometryCompression(geometry, &args);
      rtcCommitGeometry(geometry);
      rtcCommitScene(scene);
      EXPECT_EQ(statisticsOf(scene).numQuads, compression == RTC_COMPRESSION_CVERT ? quads.size() : 0u);
      EXPECT_NEAR(intersect(scene, down).ray.tfar, before.ray.tfar + 1, 1e-3);
    }
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    float P[3];
    rtcInterpolate0(geometry, 0, 0.2f, 0.2f, RTC_BUFFER_TYPE_VERTEX, 0, P, 3);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  }
}

TEST(Meshes, CommitsReportProgress) {
  Device device;
  Random random(131);
  DicedMesh lines; // triangles without area
  for (unsigned i = 0; i < 900; i++) lines.vertices.push_back({float(i), 0, 0});
  for (unsigned i = 0; i < 300; i++) lines.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  DicedMesh invalid = lines;
  for (auto& t : invalid.triangles) t[2] = 900;
  for (const DicedMesh& mesh : {meshOf(dicedSheet(8, 64), QuadOrder::Rows, random), lines, invalid}) {
    SCOPED_TRACE(mesh.size());
    struct Monitor {
      double most = 0;
      size_t calls = 0;
      std::mutex mutex;
    } monitor;
    Scene scene(device);
    attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT));
    rtcSetSceneProgressMonitorFunction(
        scene,
        [](void* self, double done) {
          Monitor& m = *(Monitor*)self;
          const std::lock_guard<std::mutex> lock(m.mutex);
          m.most = std::max(m.most, done);
          m.calls++;
          return true;
        },
        &monitor);
    rtcCommitScene(scene);
    EXPECT_GT(monitor.calls, 2u);
    EXPECT_GT(monitor.most, 0.99);
    EXPECT_LE(monitor.most, 1.0 + 1e-6);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  }
}

TEST(Meshes, MemoryIsSmall) {
  Random random(132);
  for (QuadOrder order : allQuadOrders)
    for (bool asTriangles : {false, true}) {
      Memory memory;
      Device device("cbvh_max_error=0.00011"); // 1/36 of an edge
      rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
      const DicedMesh quads = meshOf(dicedSheet(8, 64), order, random), mesh = asTriangles ? trianglesOf(quads) : quads;
      Scene scene(device);
      const ssize_t empty = memory.live;
      RTCGeometry input = newMesh(device, mesh, RTC_COMPRESSION_NONE);
      const ssize_t inputBytes = memory.live - empty;
      rtcReleaseGeometry(input);
      attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT));
      rtcCommitScene(scene);
      const double bytes = double(memory.live - empty - inputBytes) / double(quads.size());
      const RTCCompressionStatistics stats = statisticsOf(scene);
      const auto perQuad = [&](size_t n) { return double(n) / double(quads.size()); };
      std::printf("%s, %s: %.2f bytes per quad (%.2f tree, %.2f headers, %.2f groups, %.2f vertices and numbers), "
                  "%.2f more during the build\n",
                  asTriangles ? "triangles" : "quads", nameOf(order), bytes, perQuad(stats.topLevelBytes),
                  perQuad(stats.headerBytes), perQuad(stats.nodeBytes), perQuad(stats.leafBytes),
                  perQuad(size_t(memory.peak - memory.live)));
      EXPECT_LE(bytes, order == QuadOrder::Shuffled ? 6.5 : 3.5);
    }
}

// --- stored triangles -------------------------------------------------------------------------

TEST(Meshes, TrianglesOfHitsAreReported) {
  Device device;
  Random random(133);
  for (QuadOrder order : allQuadOrders) {
    const DicedMesh quads = meshOf(dicedSheet(3, 16, lattice), order, random);
    const DicedMesh triangles = trianglesOf(quads, 2, 1);
    const DicedMesh anyhow = unwelded(withTurnedTriangles(withShuffledFaces(triangles, random), random));
    for (const DicedMesh& mesh : {quads, triangles, halvesApart(triangles), anyhow, irregularQuads(quads, random),
                                  irregularTriangles(quads, random), partlyIrregular(quads, random, false),
                                  partlyIrregular(quads, random, true)}) {
      Scene scene(device);
      RTCGeometry geometry = newMesh(device, mesh, RTC_COMPRESSION_CVERT);
      attach(scene, geometry);
      rtcCommitScene(scene);
      for (int i = 0; i < 500; i++) {
        const RTCRayHit r = intersect(scene, rayAt(random, mesh));
        ASSERT_TRUE(isHit(r));
        CbvhTriangle t;
        ASSERT_TRUE(findStoredTriangle(geometry, 0, r.hit.primID, r.hit.u, r.hit.v, &r.hit.Ng_x, &t));
        unsigned v[3];
        if (mesh.isTriangleForm()) std::copy_n(mesh.triangles[r.hit.primID].data(), 3, v);
        else {
          const auto& q = mesh.quads[r.hit.primID];
          const bool isSecond = r.hit.u + r.hit.v > 1;
          v[0] = q[isSecond ? 2 : 0];
          v[1] = q[isSecond ? 3 : 1];
          v[2] = q[isSecond ? 1 : 3];
        }
        for (int c = 0; c < 3; c++)
          ASSERT_EQ(Vec({t.vertices[c][0], t.vertices[c][1], t.vertices[c][2]}), mesh.vertices[v[c]]);
        // u and v of the corners: the triangle has the hit's point at the hit's u and v
        const double edgeU[2] = {double(t.u[1]) - t.u[0], double(t.u[2]) - t.u[0]};
        const double edgeV[2] = {double(t.v[1]) - t.v[0], double(t.v[2]) - t.v[0]};
        const double area = edgeU[0] * edgeV[1] - edgeU[1] * edgeV[0], du = r.hit.u - t.u[0], dv = r.hit.v - t.v[0];
        ASSERT_EQ(std::fabs(area), 1);
        const double b = (du * edgeV[1] - dv * edgeU[1]) / area, c = (dv * edgeU[0] - du * edgeV[0]) / area;
        const float org[3] = {r.ray.org_x, r.ray.org_y, r.ray.org_z}, dir[3] = {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z};
        for (int k = 0; k < 3; k++)
          ASSERT_NEAR((1 - b - c) * t.vertices[0][k] + b * t.vertices[1][k] + c * t.vertices[2][k],
                      org[k] + double(r.ray.tfar) * dir[k], 1e-4)
              << "b " << b << ", c " << c;
      }
      CbvhTriangle t;
      EXPECT_FALSE(findStoredTriangle(geometry, 0, unsigned(mesh.size()), 0.3f, 0.3f, nullptr, &t));

      std::set<unsigned> met;
      forEachStoredPart(
          geometry, 0,
          [](void* userPtr, const CbvhPart* part) {
            const unsigned n = part->primitivesPerQuad;
            for (unsigned i = 0; i < (part->width - 1) * (part->height - 1) * n; i++)
              if (n == 1 || i % 2 == 0 || part->primIDs[i] != part->primIDs[i - 1]) {
                EXPECT_TRUE(((std::set<unsigned>*)userPtr)->insert(part->primIDs[i]).second);
              }
            return true;
          },
          &met);
      EXPECT_EQ(met.size(), mesh.size());
      EXPECT_EQ(*met.rbegin(), mesh.size() - 1);
    }
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(Meshes, PointQueriesMatchEmbree) {
  Device device;
  Random random(134);
  const DicedMesh quads = meshOf(dicedSheet(4, 16, lattice), QuadOrder::Rows, random);
  const DicedMesh triangles = trianglesOf(quads, 1, 0);
  for (const DicedMesh& mesh : {quads, triangles, halvesApart(triangles), withTurnedTriangles(triangles, random),
                                irregularQuads(quads, random), irregularTriangles(quads, random),
                                partlyIrregular(quads, random, false), partlyIrregular(quads, random, true)}) {
    const MeshScene embree(device, mesh, RTC_COMPRESSION_NONE), scene(device, mesh);
    struct Found {
      const DicedMesh* mesh;
      Vec at;
      std::set<unsigned> near;
      size_t calls = 0;
    };
    // primitives with one of their first three vertices within the radius
    const auto near = [&](RTCScene in, const Vec& at, float radius) {
      Found found{&mesh, at, {}};
      RTCPointQuery query;
      query.x = at[0];
      query.y = at[1];
      query.z = at[2];
      query.time = 0;
      query.radius = radius;
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      rtcPointQuery(
          in, &query, &context,
          [](RTCPointQueryFunctionArguments* args) {
            Found& f = *(Found*)args->userPtr;
            f.calls++;
            const unsigned* v =
                f.mesh->isTriangleForm() ? f.mesh->triangles[args->primID].data() : f.mesh->quads[args->primID].data();
            for (int c = 0; c < 3; c++) {
              const Vec& p = f.mesh->vertices[v[c]];
              if (std::hypot(p[0] - f.at[0], p[1] - f.at[1], p[2] - f.at[2]) <= args->query->radius)
                f.near.insert(args->primID);
            }
            return false;
          },
          &found);
      return found;
    };
    size_t all = 0, calls = 0;
    for (int i = 0; i < 200; i++) {
      const Vec at = {float(random.uniform(-1.1, 1.1)), float(random.uniform(-1.1, 1.1)),
                      float(random.uniform(-0.3, 0.3))};
      const float radius = float(random.uniform(0, 0.4));
      const Found expected = near(embree, at, radius), found = near(scene, at, radius);
      ASSERT_EQ(expected.near, found.near);
      all += expected.near.size();
      calls += found.calls;
    }
    EXPECT_GT(all, 1000u);
    EXPECT_LT(calls, 3 * all) << "too many calls for distant primitives";
  }
}

}} // namespace programs::test
