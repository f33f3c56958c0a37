// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/view_options.h"
#include "support/random.h"
#include "tracing/camera.h"

#include <algorithm>

namespace cbvh::test {
namespace {

TEST(Camera, FittedViewContainsAllPointsCenteredAndUpToItsBorder)
{
  Random random(7);
  for (int round = 0; round < 200; round++)
  {
    const auto vector = [&] { return Vec3f{float(random.normal()), float(random.normal()), float(random.normal())}; };
    const Vec3f stretch{float(random.magnitude(0.1, 10)), float(random.magnitude(0.1, 10)), 1.0f};
    std::vector<Vec3f> points;
    for (int i = 0; i < 40; i++)
    {
      const Vec3f p = vector();
      points.push_back({stretch.x * p.x, stretch.y * p.y, p.z});
    }
    ViewHints hints;
    hints.direction = vector();
    const ImageSize size{int(200 + random.below(800)), int(200 + random.below(800))};
    const Camera camera = Camera::fit(points, 0, hints, 35, size);

    /* In units of half pictures from the center, from three directions through pixels. */
    const Vec3f forward = normalize(camera.lookAt() - camera.eye());
    const auto tangent = [&](float x, float y) {
      const Vec3f d = camera.direction(x, y);
      return (1.0f / dot(d, forward)) * d - forward;
    };
    const float middleX = 0.5f * float(size.width) - 0.5f, middleY = 0.5f * float(size.height) - 0.5f;
    const Vec3f axes[2] = {tangent(middleX + 0.5f * float(size.width), middleY),
                           tangent(middleX, middleY + 0.5f * float(size.height))};
    float rim = 0;
    for (const Vec3f& axis : axes)
    {
      float lower = INFINITY, upper = -INFINITY;
      for (const Vec3f& p : points)
      {
        const Vec3f v = p - camera.eye();
        ASSERT_GT(dot(v, forward), 0.0f) << round;
        const float at = dot(v, axis) / (dot(v, forward) * dot(axis, axis));
        lower = std::min(lower, at);
        upper = std::max(upper, at);
      }
      EXPECT_NEAR(lower, -upper, 1e-3f) << round;
      rim = std::max(rim, upper);
    }
    EXPECT_NEAR(rim, 0.96f, 1e-3f) << round;
  }
}

TEST(Camera, DescriptionIsTheSameViewFarFromTheOrigin)
{
  const Camera camera({431234.56f, 5412345.5f, 120.123f}, {431200.1f, 5412300.5f, 1e-7f}, {0, 0, 1}, 35.1f, {64, 48});
  const Camera read = parseView(camera.description(), {0, 0, 1}, {64, 48});
  EXPECT_EQ(length(read.eye() - camera.eye()), 0.0f) << camera.description();
  EXPECT_EQ(length(read.lookAt() - camera.lookAt()), 0.0f);
  EXPECT_EQ(read.fov(), camera.fov());
}

} // namespace
} // namespace cbvh::test
