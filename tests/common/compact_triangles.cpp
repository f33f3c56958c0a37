// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* NAIVE-compact has NAIVE's triangles in Embree's compact mode: the same hits in less memory. */

#include "basics/error.h"
#include "building/built_scene.h"
#include "scenes/cube.h"
#include "tracing/ray_sets.h"
#include "tracing/trace_hits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace programs::test { namespace {

BuildSettings atLevel(int level) {
  BuildSettings settings;
  settings.level = level;
  settings.threads = 1;
  return settings;
}

/* Both of Embree's kernels use the same method, but round differently. Errors of floats grow by the ratio of distances,
 * below 6, to edges of quads, 1/16, and by the reciprocal cosine of the angle of incidence. None of these rays is at an
 * edge, where either triangle would be valid. */
void expectSameHits(const BuiltScene& expected, const BuiltScene& actual, const std::vector<Ray>& rays) {
  const std::vector<SurfaceHit> a = traceClosest(expected, rays, 1), b = traceClosest(actual, rays, 1);
  size_t hits = 0, others = 0;
  double distance = 0, parameters = 0; // largest differences, multiplied by the cosine
  for (size_t i = 0; i < rays.size(); i++) {
    hits += a[i].hit();
    others += a[i].hit() != b[i].hit() || (a[i].hit() && a[i].face != b[i].face);
    if (!a[i].hit() || !b[i].hit()) continue;
    const double cosine = std::fabs(dot(a[i].normal, rays[i].direction)) / length(a[i].normal);
    distance = std::max(distance, cosine * std::fabs(double(a[i].t) - b[i].t) / a[i].t);
    parameters = std::max(
        {parameters, cosine * std::fabs(double(a[i].u) - b[i].u), cosine * std::fabs(double(a[i].v) - b[i].v)});
  }
  EXPECT_GT(hits, rays.size() / 5);
  EXPECT_EQ(others, 0u);
  const double rounding = 6 * 16 * std::numeric_limits<float>::epsilon();
  EXPECT_LE(distance, rounding);
  EXPECT_LE(parameters, rounding);
}

std::vector<Ray> raysAtCube() { return primaryRays(Camera({3, 2, 4}, {0, 0, 0}, {0, 1, 0}, 40.0f, {101, 97})); }

TEST(CompactTriangles, HitsAreNaivesInLessMemory) {
  const Model model = makeCube();
  const BuiltScene naive(model, {RepresentationKind::Naive}, atLevel(5));
  const BuiltScene compact(model, {RepresentationKind::NaiveCompact}, atLevel(5));
  EXPECT_EQ(rtcGetSceneFlags(naive.handle()) & RTC_SCENE_FLAG_COMPACT, 0);
  EXPECT_NE(rtcGetSceneFlags(compact.handle()) & RTC_SCENE_FLAG_COMPACT, 0);
  EXPECT_EQ(compact.report().quads, naive.report().quads);
  EXPECT_LT(double(compact.report().liveBytes), 0.8 * double(naive.report().liveBytes));
  EXPECT_LT(compact.report().peakBytes, naive.report().peakBytes);
  expectSameHits(naive, compact, raysAtCube());
}

TEST(CompactTriangles, FiltersDoNotReplaceTheCompactMode) {
  BuildSettings settings = atLevel(2);
  settings.filters = true;
  const BuiltScene scene(makeCube(), {RepresentationKind::NaiveCompact}, settings);
  EXPECT_EQ(rtcGetSceneFlags(scene.handle()), RTC_SCENE_FLAG_COMPACT | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
}

/* For a mesh, GRID is Embree's kernel for its quads or triangles. */
TEST(CompactTriangles, MeshesHaveEmbreesKernelInCompactMode) {
  const BuiltScene cage(makeCube(), {RepresentationKind::CVert}, atLevel(5));
  const StoredMesh stored = cage.storedMesh();
  for (const bool asTriangles : {false, true}) {
    SCOPED_TRACE(asTriangles ? "triangles" : "quads");
    Model mesh;
    mesh.isMesh = true;
    mesh.cage.positions = stored.vertices;
    for (const std::array<unsigned, 4>& q : stored.quads)
      if (asTriangles)
        mesh.cage.faceIndices.insert(mesh.cage.faceIndices.end(), {q[0], q[1], q[3], q[3], q[1], q[2], q[3], q[3]});
      else mesh.cage.faceIndices.insert(mesh.cage.faceIndices.end(), q.begin(), q.end());
    mesh.cage.faceSizes.assign(mesh.cage.faceIndices.size() / 4, 4);
    const BuiltScene embree(mesh, {RepresentationKind::Grid}, atLevel(0));
    const BuiltScene compact(mesh, {RepresentationKind::NaiveCompact}, atLevel(0));
    EXPECT_LT(double(compact.report().liveBytes), 0.8 * double(embree.report().liveBytes));
    expectSameHits(embree, compact, raysAtCube());
    EXPECT_THROW(BuiltScene(mesh, {RepresentationKind::Naive}, atLevel(0)), Error);
  }
}

}} // namespace programs::test
