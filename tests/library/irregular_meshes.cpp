// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Meshes without grids are stored in mesh blocks, and hits match Embree's own kernels. */

#include "support/closed.h"
#include "support/filtered_geometry.h"
#include "support/irregular_mesh.h"
#include "support/memory.h"
#include "support/same_hits.h"
#include <map>
#include <utility>

namespace programs::test { namespace {

const double lattice = 0x1p-10;
const double slack = 1e-3; // of parameters: triangles are small

class IrregularMeshes : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Isas, IrregularMeshes, testing::Values(TEST_ISAS), nameOfIsa);

void expectEmbreesHits(const Device& device, const DicedMesh& mesh, Random& random) {
  const MeshScene embree(device, mesh, RTC_COMPRESSION_NONE), scene(device, mesh);
  const RTCCompressionStatistics stats = statisticsOf(scene);
  ASSERT_GE(stats.numQuads, mesh.isTriangleForm() ? mesh.size() / 2 : mesh.size());
  ASSERT_GE(stats.numIrregularQuads, stats.numQuads / 8);
  ASSERT_EQ(stats.maxVertexDeviation, 0) << "all vertices are on the lattice";
  expectSameQueries(embree, scene, raysAt(random, mesh, 1003), slack);
}

TEST_P(IrregularMeshes, HitsMatchEmbree) {
  for (const char* error : {"", ",cbvh_max_error=0"}) {
    Device device((GetParam() + std::string(error)).c_str());
    if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
    Random random(151);
    for (const NamedMesh& shape : irregularMeshes(random, lattice)) {
      SCOPED_TRACE(shape.name + error);
      expectEmbreesHits(device, shape.mesh, random);
      if (HasFatalFailure()) return;
    }
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  }
}

TEST_P(IrregularMeshes, MasksFiltersAndInstances) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(152);
  for (const NamedMesh& shape : irregularMeshes(random, lattice)) {
    SCOPED_TRACE(shape.name);
    const DicedMesh& mesh = shape.mesh;
    const auto make = [&](RTCCompression compression) { return newMesh(device, mesh, compression); };
    ASSERT_NO_FATAL_FAILURE(expectSameFilteredHits(device, make, false, raysAt(random, mesh, 503), slack));
  }
}

// Rays from inside a closed surface at edges and vertices, for any lattice, welded or not.
TEST_P(IrregularMeshes, ClosedSurfacesDoNotLeak) {
  for (const char* error : {"", ",cbvh_max_error=0", ",cbvh_max_error=0.002", ",cbvh_max_error=0.05"}) {
    Device device((GetParam() + std::string(error)).c_str());
    if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
    Random random(153);
    const DicedMesh ball = jittered(meshOf(dicedBall(3, 16), QuadOrder::Rows, random), random, 0.005);
    const DicedMesh triangles = partlyIrregular(ball, random, true), quads = partlyIrregular(ball, random, false);
    for (const DicedMesh& mesh : {irregularTriangles(ball, random), irregularQuads(ball, random), triangles, quads,
                                  unwelded(triangles), unwelded(quads)}) {
      SCOPED_TRACE(std::string(error) + (mesh.isTriangleForm() ? ", triangles" : ", quads"));
      const MeshScene scene(device, mesh);
      ASSERT_GT(statisticsOf(scene).numIrregularQuads, 1500u);
      std::vector<RTCRayHit> rays;
      for (unsigned i = 0; i < 20000; i++) {
        const unsigned* v = mesh.isTriangleForm() ? mesh.triangles[random.below(unsigned(mesh.size()))].data()
                                                  : mesh.quads[random.below(unsigned(mesh.size()))].data();
        const unsigned n = mesh.isTriangleForm() ? 3 : 4, k = random.below(n);
        rays.push_back(rayFromMiddle(random, mesh.vertices[v[k]], mesh.vertices[v[(k + 1) % n]]));
      }
      expectNoneMisses(scene, rays);
    }
  }
}

// Divides edges of some triangles of a closed mesh in the middle. A flat triangle closes the gap to the undivided
// neighbor, alone or as half of a quad.
DicedMesh dividedOnOneSide(DicedMesh mesh, Random& random, bool asQuads) {
  DicedMesh out;
  for (Vec& p : mesh.vertices)
    for (float& x : p) x = roundTo(x, 0x1p-12);
  out.vertices = mesh.vertices;
  std::map<std::pair<unsigned, unsigned>, size_t> triangleAt;
  for (size_t i = 0; i < mesh.triangles.size(); i++)
    for (int c = 0; c < 3; c++) triangleAt[{mesh.triangles[i][c], mesh.triangles[i][(c + 1) % 3]}] = i;
  const auto add = [&](unsigned a, unsigned b, unsigned c) {
    if (asQuads) out.quads.push_back({a, b, c, c});
    else out.triangles.push_back({a, b, c});
  };
  std::vector<bool> isDone(mesh.triangles.size());
  for (size_t i = 0; i < mesh.triangles.size(); i++) {
    const auto [a, b, c] = mesh.triangles[i];
    const size_t neighbor = triangleAt.at({b, a});
    if (isDone[i] || isDone[neighbor] || random.chance(0.5)) continue;
    const unsigned middle = unsigned(out.vertices.size());
    Vec m;
    for (int k = 0; k < 3; k++) m[k] = 0.5f * (mesh.vertices[a][k] + mesh.vertices[b][k]); // exact
    out.vertices.push_back(m);
    add(a, middle, c);
    add(middle, b, c);
    isDone[i] = true;
    const auto& t = mesh.triangles[neighbor];
    const unsigned d = t[0] != a && t[0] != b ? t[0] : t[1] != a && t[1] != b ? t[1] : t[2];
    if (asQuads) out.quads.push_back({middle, a, d, b});
    else {
      add(a, b, middle);
      add(b, a, d);
    }
    isDone[neighbor] = true;
  }
  for (size_t i = 0; i < mesh.triangles.size(); i++)
    if (!isDone[i]) add(mesh.triangles[i][0], mesh.triangles[i][1], mesh.triangles[i][2]);
  return out;
}

TEST_P(IrregularMeshes, FlatTrianglesCloseGaps) {
  for (const char* error : {"", ",cbvh_max_error=0", ",cbvh_max_error=0.002", ",cbvh_max_error=0.02"}) {
    Device device((GetParam() + std::string(error)).c_str());
    if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
    Random random(154);
    const DicedMesh ball = jittered(meshOf(dicedBall(3, 16), QuadOrder::Rows, random), random, 0.005),
                    closed = irregularTriangles(ball, random);
    for (bool asQuads : {false, true}) {
      SCOPED_TRACE(std::string(error) + (asQuads ? ", quads" : ", triangles"));
      const DicedMesh mesh = dividedOnOneSide(closed, random, asQuads);
      ASSERT_GT(mesh.vertices.size(), closed.vertices.size() + 500);
      const MeshScene scene(device, mesh);
      ASSERT_GT(statisticsOf(scene).numIrregularQuads, 1000u);
      std::vector<RTCRayHit> rays;
      for (unsigned i = 0; i < 20000; i++) {
        const auto& t = closed.triangles[random.below(unsigned(closed.triangles.size()))];
        rays.push_back(rayFromMiddle(random, mesh.vertices[t[0]], mesh.vertices[t[1]]));
      }
      expectNoneMisses(scene, rays);
    }
  }
}

TEST(IrregularMeshesOfFewBytes, MemoryIsSixToSevenBytesPerTriangle) {
  Memory memory;
  Device device;
  rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
  Random random(154);
  const DicedMesh quads = jittered(meshOf(dicedSheet(1, 200), QuadOrder::Rows, random), random, 0.002),
                  mesh = irregularTriangles(quads, random, false);
  Scene scene(device);
  const ssize_t empty = memory.live;
  RTCGeometry input = newMesh(device, mesh, RTC_COMPRESSION_NONE);
  const ssize_t inputBytes = memory.live - empty;
  rtcReleaseGeometry(input);
  attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT));
  rtcCommitScene(scene);
  const double bytes = double(memory.live - empty - inputBytes) / double(mesh.size());
  const RTCCompressionStatistics stats = statisticsOf(scene);
  const auto each = [&](size_t n) { return double(n) / double(mesh.size()); };
  std::printf("%.2f bytes per triangle (%.2f tree, %.2f headers, %.2f boxes, %.2f the rest)\n", bytes,
              each(stats.topLevelBytes), each(stats.headerBytes), each(stats.nodeBytes), each(stats.leafBytes));
  EXPECT_LE(each(stats.topLevelBytes + stats.headerBytes + stats.nodeBytes + stats.leafBytes), 6.7);
  EXPECT_LE(bytes, 7.2); // including unused memory of the allocator
}

// If most triangles are so thin that the default lattice flips them, all vertices use a finer one.
TEST(IrregularMeshesOfFewBytes, TheLatticeIsFinerIfMostTrianglesAreThin) {
  const auto spacingOf = [](float width, unsigned thin) {
    Device device;
    Random random(156);
    DicedMesh mesh;
    for (unsigned i = 0; i < 4000; i++) {
      float p[3];
      for (float& x : p) x = float(random.uniform(0, 100));
      const float y = i % 10 < thin ? width : 0.5f;
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
      mesh.vertices.push_back({p[0], p[1], p[2]});
      mesh.vertices.push_back({p[0] + 1, p[1] + 0.3f, p[2] + 0.2f});
      mesh.vertices.push_back({p[0] + 1, p[1] + 0.3f + y, p[2] + 0.2f - y});
    }
    Scene scene(device);
    attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT));
    rtcCommitScene(scene);
    const RTCCompressionStatistics stats = statisticsOf(scene);
    EXPECT_EQ(stats.numIrregularQuads, 2000u);
    EXPECT_LE(stats.maxVertexDeviation, 0.8661 * stats.maxVertexSpacing);
    return stats.maxVertexSpacing;
  };
  const double fine = spacingOf(5e-5f, 8), coarse = spacingOf(5e-5f, 3);
  EXPECT_GT(fine, 0);
  EXPECT_LE(fine, coarse / 64);
  EXPECT_EQ(spacingOf(0.5f, 8), coarse);
}

// Blocks of a part of a mesh leave no large remainders of allocations.
TEST(IrregularMeshesOfFewBytes, BlocksOfAnyNumberOfTrianglesAreAllocatedExactly) {
  for (unsigned side : {150, 180, 205, 230, 255, 290, 520}) {
    SCOPED_TRACE(side);
    Memory memory;
    Device device("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    Random random(155);
    const DicedMesh mesh =
        irregularTriangles(jittered(meshOf(dicedSheet(1, side), QuadOrder::Rows, random), random, 0.3 / side), random);
    Scene scene(device);
    const ssize_t before = memory.live;
    attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT));
    rtcCommitScene(scene);
    const RTCCompressionStatistics stats = statisticsOf(scene);
    const double stored =
        double(stats.topLevelBytes + stats.headerBytes + stats.nodeBytes + stats.leafBytes + stats.inputBytes);
    EXPECT_LE(double(memory.live - before) - stored, 0.05 * stored);
  }
}

// In a mesh that is mostly irregular, small grids without an order of their triangles would take more memory.
TEST(IrregularMeshesOfFewBytes, SmallGridsOfIrregularMeshesBecomeMeshBlocks) {
  Device device;
  Random random(156);
  const unsigned side = 112;
  const DicedMesh sheet = jittered(meshOf(dicedSheet(1, side), QuadOrder::Rows, random), random, 0.3 / side);
  DicedMesh regular = sheet, others = sheet;
  regular.quads.clear();
  others.quads.clear();
  for (unsigned i = 0; i < sheet.quads.size(); i++) // of 8 x 7 quads, 5 x 5 are regular
    (i % side % 8 < 5 && i / side % 7 < 5 ? regular : others).quads.push_back(sheet.quads[i]);
  DicedMesh mesh = irregularTriangles(others, random);
  for (const auto& triangle : trianglesOf(regular).triangles) mesh.triangles.push_back(triangle);
  mesh = withShuffledFaces(mesh, random);
  const MeshScene mixed(device, mesh), irregular(device, irregularTriangles(sheet, random));
  const RTCCompressionStatistics stats = statisticsOf(mixed);
  EXPECT_GE(stats.numIrregularQuads, 0.99 * double(stats.numQuads)); // a few regions are larger by chance
  EXPECT_LE(double(stats.numBlocks), 1.1 * double(statisticsOf(irregular).numBlocks));
}

}} // namespace programs::test
