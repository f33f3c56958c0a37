// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cbvh_max_error=0: the vertices of grids, quads and triangles are stored to the bit, wherever they are, so that rays hit what Embree's own kernels
 * hit. vert_surfaces.cpp has cages, moving_meshes.cpp what moves. */

#include "support/diced.h"
#include "support/diced_mesh.h"
#include "support/query_forms.h"
#include "support/random.h"
#include "support/same_hits.h"

#include <embree3/rtcore_compressed_triangles.h>

#include <cmath>
#include <set>
#include <string>

namespace cbvh::test {
namespace {

const std::string lossless = "cbvh_max_error=0";

class Lossless : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Isas, Lossless, testing::Values(TEST_ISAS), nameOfIsa);

template<typename Embree, typename Ours, typename Rays>
void expectEmbreesHits(const Embree& embree, const Ours& scene, const Rays& rays)
{
  const RTCCompressionStatistics stats = statisticsOf(scene);
  ASSERT_GT(stats.numQuads, 0u);
  ASSERT_EQ(statisticsOf(embree).numQuads, 0u);
  ASSERT_EQ(stats.maxVertexDeviation, 0);
  ASSERT_EQ(stats.maxVertexSpacing, 0);
  ASSERT_EQ(stats.numRawBlocks, 0u);
  for (QueryForm form : allQueryForms) {
    SCOPED_TRACE(nameOf(form));
    const std::vector<RTCRayHit> expected = closestHits(embree, rays, form);
    ASSERT_NO_FATAL_FAILURE(expectSameHits(expected, closestHits(scene, rays, form), 2e-3));
    const std::vector<RTCRayHit> any = anyHits(scene, rays, form);
    for (size_t i = 0; i < rays.size(); i++) ASSERT_EQ(any[i].ray.tfar < 0, isHit(expected[i])) << "ray " << i;
  }
}

TEST_P(Lossless, HitsAreEmbrees)
{
  Device device(GetParam() + ("," + lossless));
  if (!device) GTEST_SKIP() << "this machine does not run " << GetParam();
  Random random(1501);
  const struct { const char* name; Diced diced; } shapes[] = {
    {"a grid of 64 quads", dicedSheet(1, 64)}, {"grids of 8 quads", dicedSheet(5, 8)}, {"grids of 33 quads", dicedSheet(2, 33)}, {"a ball", dicedBall(2, 16)}};
  for (const auto& shape : shapes) {
    SCOPED_TRACE(shape.name);
    ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(GridScene(device, shape.diced, RTC_COMPRESSION_NONE), GridScene(device, shape.diced), raysAt(random, shape.diced, 403)));
    const DicedMesh quads = meshOf(shape.diced, QuadOrder::Rows, random), triangles = trianglesOf(quads, 1, 2);
    for (const DicedMesh& mesh : {quads, triangles})
      ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(MeshScene(device, mesh, RTC_COMPRESSION_NONE), MeshScene(device, mesh), raysAt(random, mesh, 403)));
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

Vec withoutSign(const Vec& p) { return {p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f}; } // of zeros

// What is handed out of the geometry, but for what is not finite.
std::set<Vec> storedVertices(RTCGeometry geometry)
{
  std::set<Vec> vertices;
  rtcForEachCompressedPart(geometry, [](void* out, const RTCCompressedPart* part) {
    for (unsigned i = 0; i < part->width*part->height; i++) {
      const float* p = part->vertices + 3*i;
      if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) ((std::set<Vec>*)out)->insert(withoutSign({p[0], p[1], p[2]}));
    }
    return true;
  }, &vertices);
  return vertices;
}

// Of sizes from 1e-30 to 1e12, other ones on each axis, around the origin or far from it, with stray vertices.
Vec randomPlace(const Vec& p, const double scale[3], const double away[3])
{
  Vec q;
  for (int k = 0; k < 3; k++) q[k] = float(scale[k]*p[k] + away[k]);
  return q;
}

TEST(LosslessVertices, AreTheApplicationsWhereverTheyAre)
{
  Device device(lossless);
  Random random(1502);
  for (int round = 0; round < 60; round++) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    double scale[3], away[3];
    const double common = random.magnitude(1e-30, 1e12);
    for (int k = 0; k < 3; k++) {
      scale[k] = round % 3 ? common : random.magnitude(1e-30, 1e12);
      away[k] = round % 2 ? 0 : scale[k]*random.magnitude(1, 1e5)*(random.chance(0.5) ? 1 : -1);
    }
    Diced diced = round % 4 ? dicedSheet(2, 20) : dicedBall(1, 20);
    for (Vec& p : diced.vertices) p = randomPlace(p, scale, away);
    if (round % 5 == 0) diced.vertices[random.below(unsigned(diced.vertices.size()))][round % 3] = float(random.magnitude(1e6, 1e17));
    std::set<Vec> expected;
    for (const Vec& p : diced.vertices) expected.insert(withoutSign(p));
    const DicedMesh quads = meshOf(diced, QuadOrder::Rows, random);
    const std::pair<const char*, RTCGeometry> geometries[] = {
      {"grids", newGrids(device, diced, RTC_COMPRESSION_VERT)}, {"quads", newMesh(device, quads, RTC_COMPRESSION_VERT)}, {"triangles", newMesh(device, trianglesOf(quads), RTC_COMPRESSION_VERT)}};
    for (const auto& g : geometries) {
      SCOPED_TRACE(g.first);
      Scene scene(device);
      rtcRetainGeometry(g.second);
      attach(scene, g.second);
      rtcCommitScene(scene);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      EXPECT_GT(statisticsOf(scene).numQuads, 0u);
      EXPECT_EQ(statisticsOf(scene).maxVertexDeviation, 0);
      EXPECT_TRUE(storedVertices(g.second) == expected);
      rtcReleaseGeometry(g.second);
    }
  }
}

// Where floats do not take that much of it.
TEST(LosslessVertices, TakeFewerBytesThanEmbree)
{
  Device device(lossless);
  Random random(1503);
  Diced terrain;
  terrain.add(257, 257, [&](unsigned x, unsigned y) { return Vec{float(x), float(y), float(100 + 3*std::sin(0.05*x) + 2*std::cos(0.07*y) + 0.01*random.normal())}; });
  const RTCCompressionStatistics stats = statisticsOf(GridScene(device, terrain));
  EXPECT_EQ(stats.numRawBlocks, 0u);
  EXPECT_LT(double(stats.frameBytes + stats.nodeBytes + stats.leafBytes)/double(stats.numQuads), 2.9);
  const RTCCompressionStatistics ball = statisticsOf(GridScene(device, dicedBall(4, 64)));
  EXPECT_LT(ball.numRawBlocks, ball.numBlocks/20);
  EXPECT_LT(double(ball.frameBytes + ball.nodeBytes + ball.leafBytes)/double(ball.numQuads), 8);
}

} // namespace
} // namespace cbvh::test
