// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Surfaces of cVERT: closed by sharing, as near to GRID's as promised, and traced as the
 * scalar decoder has them. */

#include "support/edge_rates.h"
#include "support/vert_triangles.h"
#include "support/vertex_recorder.h"

#include <cmath>

namespace cbvh::test {
namespace {

constexpr double ulp = 0x1p-23;

// Along the face's own normal, which at an extraordinary vertex is not that of its neighbours.
struct AlongNormals : public VertexRecorder
{
  float amplitude = 0.1f, jump = 0; // jump: heights of faces differ by up to this
  std::vector<Vec> recorded;

  static void displaceAlongNormals(const RTCDisplacementFunctionNArguments* args)
  {
    const AlongNormals& d = *static_cast<AlongNormals*>((Displacement*)args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; i++) {
      const float h = d.amplitude*std::sin(9*args->P_x[i] + 5*args->P_y[i])*std::cos(7*args->P_z[i]) + d.jump*float(args->primID % 3);
      args->P_x[i] += h*args->Ng_x[i];
      args->P_y[i] += h*args->Ng_y[i];
      args->P_z[i] += h*args->Ng_z[i];
    }
  }

  void record(const RTCDisplacementFunctionNArguments&) override {}
};

SurfaceSettings vert(float rate = 16)
{
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_VERT;
  settings.rate = rate;
  return settings;
}

void commitAlongNormals(RTCDevice device, RTCScene scene, const Cage& cage, const SurfaceSettings& settings, AlongNormals& displacement)
{
  RTCGeometry geometry = newSurface(device, cage, settings);
  rtcSetGeometryUserData(geometry, static_cast<Displacement*>(&displacement));
  rtcSetGeometryDisplacementFunction(geometry, AlongNormals::displaceAlongNormals);
  rtcCommitGeometry(geometry);
  attach(scene, geometry);
  rtcCommitScene(scene);
}

// Every edge of every triangle is another's, the other way round, to the last bit: then no ray
// can pass between two of them.
TEST(VertSurfaces, ClosedSurfacesShareEveryEdge)
{
  Device device;
  for (const auto& cage : closedCages)
    for (float rate : {1.0f, 2.0f, 3.0f, 5.0f, 8.0f, 13.0f, 17.0f, 64.0f}) {
      SCOPED_TRACE(testing::Message() << cage.name << ", rate " << rate);
      Displacement displacement;
      SurfaceSettings settings = vert(rate);
      settings.displacement = &displacement;
      const SurfaceScene scene(device, cage.cage, settings);
      const std::vector<VertTriangle> triangles = vertTriangles(scene);
      EXPECT_EQ(2*statisticsOf(scene).numQuads, triangles.size());
      EXPECT_EQ(countOpenEdges(triangles), 0u) << "of " << 3*triangles.size()/2;
      EXPECT_EQ(statisticsOf(scene).numRawBlocks, 0u);
    }
}

TEST(VertSurfaces, NeighboursOfOtherRatesShareEveryEdge)
{
  Device device;
  for (const auto& cage : closedCages)
    for (const auto& set : rateSets) {
      SCOPED_TRACE(testing::Message() << cage.name << ", rates " << set.name);
      Random random(81);
      Displacement displacement;
      SurfaceSettings settings = vert();
      settings.displacement = &displacement;
      settings.edgeRates = drawRates(cage.cage, random, set.draw);
      const SurfaceScene scene(device, cage.cage, settings);
      EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
    }
}

// Where the two sides of an edge ask for other rates GRID tears.
TEST(VertSurfaces, SidesThatDisagreeOnTheRateOfAnEdgeShareIt)
{
  Device device;
  for (const auto& cage : closedCages) {
    SCOPED_TRACE(cage.name);
    Random random(82);
    Displacement displacement;
    SurfaceSettings settings = vert();
    settings.displacement = &displacement;
    for (size_t i = 0; i < cage.cage.indices.size(); i++) settings.edgeRates.push_back(float(1 + random.below(40)));
    const SurfaceScene scene(device, cage.cage, settings);
    EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
  }
}

// GRID tears here, by hundreds of ulps or by a part of the object.
TEST(VertSurfaces, ExtraordinaryVerticesAlongNormalsAndSeamsAreClosed)
{
  Device device;
  for (const auto& cage : closedCages)
    for (float jump : {0.0f, 0.1f}) {
      SCOPED_TRACE(testing::Message() << cage.name << ", jump " << jump);
      AlongNormals displacement;
      displacement.jump = jump;
      Scene scene(device);
      commitAlongNormals(device, scene, cage.cage, vert(16), displacement);
      EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
      const RTCCompressionStatistics stats = statisticsOf(scene);
      EXPECT_GT(stats.maxBorderGap, jump);
      EXPECT_LE(stats.maxVertexDeviation, 0.8661f*stats.maxVertexSpacing);
    }
}

// --- rays ----------------------------------------------------------------------------

// The library's hit must be that of the decoded triangles, unless the ray is within rounding of
// an edge, where it may be the other triangle's.
void expectTriangleHits(RTCScene scene, const std::vector<RTCRayHit>& rays)
{
  const std::vector<VertTriangle> triangles = vertTriangles(scene);
  constexpr double rounding = 1e-4; // of weights
  size_t hits = 0, nearEdges = 0;
  for (const RTCRayHit& ray : rays) {
    ExactHit nearest, candidate;
    bool nearEdge = false;
    for (const VertTriangle& t : triangles)
      if (meet(ray.ray, t, candidate) && candidate.t >= ray.ray.tnear && candidate.t <= ray.ray.tfar && inside(candidate) >= -rounding) {
        if (candidate.t < nearest.t + 1e-5) nearEdge |= inside(candidate) < rounding;
        if (inside(candidate) >= 0 && candidate.t < nearest.t) nearest = candidate;
      }
    const RTCRayHit found = intersect(scene, ray);
    ASSERT_EQ(occluded(scene, ray), isHit(found));
    if (nearEdge) { nearEdges++; continue; }
    ASSERT_EQ(isHit(found), nearest.triangle != nullptr) << "t " << nearest.t << " found " << found.ray.tfar << " prim " << found.hit.primID << " " << found.hit.u << " " << found.hit.v;
    if (!isHit(found)) continue;
    hits++;
    const VertTriangle& t = *nearest.triangle;
    ASSERT_EQ(found.hit.primID, t.primID);
    ASSERT_NEAR(found.ray.tfar, nearest.t, 64*ulp*std::max(1.0, nearest.t));
    double u = 0, v = 0, n[3], e[2][3];
    for (int c = 0; c < 3; c++) { u += nearest.weight[c]*t.u[c]; v += nearest.weight[c]*t.v[c]; }
    ASSERT_NEAR(found.hit.u, u, 1e-4);
    ASSERT_NEAR(found.hit.v, v, 1e-4);
    for (int k = 0; k < 3; k++) { e[0][k] = double(t.vertices[1][k]) - t.vertices[0][k]; e[1][k] = double(t.vertices[2][k]) - t.vertices[0][k]; }
    for (int k = 0; k < 3; k++) n[k] = e[0][(k+1)%3]*e[1][(k+2)%3] - e[0][(k+2)%3]*e[1][(k+1)%3];
    const double length = std::sqrt(n[0]*n[0] + n[1]*n[1] + n[2]*n[2]);
    const float ng[3] = {found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z};
    for (int k = 0; k < 3; k++) ASSERT_NEAR(ng[k], n[k], 1e-5*length);
  }
  EXPECT_GT(hits, rays.size()/4);
  EXPECT_LT(nearEdges, rays.size()/10);
}

class VertRays : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Isas, VertRays, testing::Values(TEST_ISAS), [](const auto& info) {
  std::string name;
  for (char c : info.param.substr(4)) if (c != '.') name += c;
  return name;
});

TEST_P(VertRays, HitTheDecodedTriangles)
{
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not run " << GetParam();
  Random random(83);
  for (const auto& cage : closedCages)
    for (float rate : {1.0f, 2.0f, 3.0f, 6.0f, 16.0f, 21.0f}) {
      SCOPED_TRACE(testing::Message() << cage.name << ", rate " << rate);
      Displacement displacement;
      displacement.amplitude = 0.1f;
      SurfaceSettings settings = vert(rate);
      settings.displacement = &displacement;
      const SurfaceScene scene(device, cage.cage, settings);
      expectTriangleHits(scene, raysAt(random, 200));
      if (HasFatalFailure()) return;
    }
}

} // namespace
} // namespace cbvh::test
