// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/silhouettes.h"
#include "tracing/ray_sets.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace programs::test { namespace {

// A camera in front of planes, and the hit of each pixel.
class Silhouettes : public testing::Test {
protected:
  static constexpr int size = 16;
  const Camera camera{{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 40, {size, size}};
  const std::vector<Ray> rays = primaryRays(camera);

  // Hit of a plane with this normal, which the camera's axis crosses at `depth`.
  SurfaceHit hitOf(size_t ray, float depth, Vec3f normal) const {
    SurfaceHit hit;
    hit.t = -depth * normal.z / dot(rays[ray].direction, normal);
    hit.normal = normal;
    hit.face = 0;
    return hit;
  }

  std::vector<size_t> away(const std::vector<SurfaceHit>& hits) const {
    return hitsAwayFromSilhouettes(rays, hits, camera);
  }
};

TEST_F(Silhouettes, PlaneHasNoneAtAnySlope) {
  for (const Vec3f& normal : {Vec3f{0, 0, 1}, Vec3f{0.9f, 0.3f, 0.5f}, Vec3f{0, 2, -4}}) {
    std::vector<SurfaceHit> hits;
    for (size_t i = 0; i < rays.size(); i++) hits.push_back(hitOf(i, 10, normal));
    EXPECT_EQ(away(hits).size(), size_t((size - 2) * (size - 2)));
  }
}

TEST_F(Silhouettes, AreNextToStepsAndTheBackground) {
  const float pixel = camera.footprint() * 10;
  for (float step : {2 * pixel, 5 * pixel, INFINITY}) {
    std::vector<SurfaceHit> hits;
    for (size_t i = 0; i < rays.size(); i++) {
      hits.push_back(hitOf(i, i % size < size / 2 ? 10 : 10 + step, {0, 0, 1}));
      if (step == INFINITY && i % size >= size / 2) hits.back() = SurfaceHit();
    }
    const std::vector<size_t> found = away(hits);
    const auto inColumn = [&](int x) {
      return std::count_if(found.begin(), found.end(), [&](size_t i) { return int(i % size) == x; });
    };
    const long rows = size - 2, beside = step == 2 * pixel ? rows : 0;
    EXPECT_EQ(inColumn(size / 2 - 2), rows);
    EXPECT_EQ(inColumn(size / 2 - 1), beside);
    EXPECT_EQ(inColumn(size / 2), beside);
    EXPECT_EQ(inColumn(size / 2 + 1), step == INFINITY ? 0 : rows);
    EXPECT_EQ(inColumn(0), 0) << "pixels on the rim have no neighbors";
  }
}

}} // namespace programs::test
