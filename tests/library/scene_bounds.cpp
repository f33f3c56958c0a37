// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* rtcGetSceneBounds contains everything that rays can hit: leaves extend beyond the vertices, and renderers clip rays
 * to the bounds. */

#include "kernels/cbvh/paper/frame_fit.h"
#include "support/random.h"
#include "support/random_sheets.h"
#include "support/scene.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace programs::test { namespace {

float outside(const RTCBounds& b, const Vec& p) {
  return std::max(
      {b.lower_x - p[0], p[0] - b.upper_x, b.lower_y - p[1], p[1] - b.upper_y, b.lower_z - p[2], p[2] - b.upper_z});
}

class SceneBounds : public testing::TestWithParam<RTCCompression> {};

// t and the point have rounding errors of a few ulps of the distance, by which the traversal widens rays (local_ray.h).
TEST_P(SceneBounds, ContainEveryHit) {
  Device device;
  Random random(61);
  unsigned hits = 0, reachesPast = 0;
  for (Shape shape : allShapes)
    for (uint32_t height = 0; height <= 5; height++) {
      const Sheet sheet = randomSheet(random, shape, height, {1, {0, 0, 0}});
      Scene scene(device), grid(device);
      commitSheet(device, scene, sheet, GetParam());
      commitSheet(device, grid, sheet, RTC_COMPRESSION_NONE);
      RTCBounds bounds, vertices;
      rtcGetSceneBounds(scene, &bounds);
      rtcGetSceneBounds(grid, &vertices);
      for (int i = 0; i < 2000; i++) {
        const RTCRayHit hit = intersect(scene, randomRay(random, RayKind::Across, sheet));
        if (!isHit(hit)) continue;
        hits++;
        const Vec p = {hit.ray.org_x + hit.ray.tfar * hit.ray.dir_x, hit.ray.org_y + hit.ray.tfar * hit.ray.dir_y,
                       hit.ray.org_z + hit.ray.tfar * hit.ray.dir_z};
        const float tolerance = 64 * std::numeric_limits<float>::epsilon() * (1 + hit.ray.tfar);
        ASSERT_LE(outside(bounds, p), tolerance) << nameOf(shape) << ", height " << height;
        reachesPast += outside(vertices, p) > tolerance;
      }
    }
  EXPECT_GT(hits, 20000u);
  if (GetParam() != RTC_COMPRESSION_CGRID) {
    EXPECT_GT(reachesPast, 0u) << "no hit is outside of the bounds of the vertices";
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, SceneBounds,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                         RTC_COMPRESSION_CVERT),
                         [](const auto& info) { return kindName(info.param); });

// Kinds whose faces round shared vertices differently. In cVERT they share the same vertices.
class RoundedBounds : public SceneBounds {};
INSTANTIATE_TEST_SUITE_P(Kinds, RoundedBounds,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF),
                         [](const auto& info) { return kindName(info.param); });

// Bounds are rounded outwards: a neighboring face, which must catch rays that pass this one, may round vertices
// differently.
TEST_P(RoundedBounds, ContainVerticesAsRoundedByAnyFace) {
  Device device;
  Random random(62);
  for (int i = 0; i < 40; i++) {
    const double scale = random.magnitude(1e-3, 1e3), away = scale * random.magnitude(1e-3, 1e3);
    const Sheet sheet = randomSheet(random, Shape::Waves, 3, {scale, {away, -0.3 * away, 0.7 * away}});
    Scene scene(device);
    commitSheet(device, scene, sheet, GetParam());
    ASSERT_EQ(statisticsOf(scene).numBlocks, 1u);
    RTCBounds bounds;
    rtcGetSceneBounds(scene, &bounds);
    double coordinate = 0;
    for (const Vec& p : sheet.vertices)
      for (float x : p) coordinate = std::max(coordinate, std::fabs(double(x)));
    const double rounding = embree::cbvh::vertexRounding * coordinate;
    const float lower[3] = {bounds.lower_x, bounds.lower_y, bounds.lower_z},
                upper[3] = {bounds.upper_x, bounds.upper_y, bounds.upper_z};
    for (const Vec& p : sheet.vertices)
      for (int k = 0; k < 3; k++) {
        ASSERT_LE(lower[k], p[k] - rounding) << "sheet " << i << ", axis " << k;
        ASSERT_GE(upper[k], p[k] + rounding) << "sheet " << i << ", axis " << k;
      }
  }
}

}} // namespace programs::test
