// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/view_options.h"
#include "scenes/cube.h"
#include "support/random.h"
#include "tracing/camera.h"

#include <algorithm>

namespace programs::test { namespace {

TEST(Camera, FittedViewContainsAllPointsCenteredAndUpToItsBorder) {
  Random random(7);
  for (int round = 0; round < 200; round++) {
    const auto vector = [&] { return Vec3f{float(random.normal()), float(random.normal()), float(random.normal())}; };
    const Vec3f stretch{float(random.magnitude(0.1, 10)), float(random.magnitude(0.1, 10)), 1.0f};
    std::vector<Vec3f> points;
    for (int i = 0; i < 40; i++) {
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
    for (const Vec3f& axis : axes) {
      float lower = INFINITY, upper = -INFINITY;
      for (const Vec3f& p : points) {
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

TEST(Camera, VerticesWithoutFacesAreOutsideOfTheFullView) {
  Model model = makeCube();
  const Box3f bounds = model.cage.bounds();
  const auto view = [&] { return fitCamera(model, bounds, model.view, 35, {64, 48}).description(); };
  const std::string before = view();
  model.cage.positions.push_back({1000, 0, 0});
  model.poses = {model.cage.positions};
  EXPECT_EQ(view(), before);
  EXPECT_EQ(model.cage.bounds().upper.x, bounds.upper.x);
  model.poses[0][7].x += 1;
  EXPECT_NE(view(), before);
}

TEST(Camera, DescriptionsFarFromTheOriginDistinguishCameras) {
  const Vec3f eye{4123456.5f, -500000.25f, 0.1f}, target{4123460.0f, -500001.0f, 1e-7f};
  const Camera camera(eye, target, {0, 1, 0}, 34.7f, {64, 48});
  EXPECT_EQ(camera.description(), "4123456.5,-500000.25,0.1,4123460,-500001,1e-07,34.7");
  const Camera beside(eye + Vec3f{0.5f, 0, 0}, target, {0, 1, 0}, 34.7f, {64, 48});
  EXPECT_NE(camera.description(), beside.description());
}

/* Only the direction of the up vector matters. */
TEST(Camera, LengthOfTheUpVectorHasNoEffect) {
  const ImageSize size{4, 3};
  const Vec3f up{1, 2, -3};
  const Vec3f expected = Camera({5, 1, 2}, {}, up, 35, size).direction(0, 0);
  for (float length : {1e-40f, 1e-20f, 1e-7f, 1e7f, 1e20f, 1e38f}) {
    const Vec3f found = Camera({5, 1, 2}, {}, length * up, 35, size).direction(0, 0);
    EXPECT_NEAR(dot(found, expected), 1.0f, 1e-4f) << length;
  }
}

TEST(Camera, ViewsAlongTheUpVectorHaveDifferentDirections) {
  for (const Vec3f& up : {Vec3f{0, 1, 0}, Vec3f{1, 1, 1}, Vec3f{-1, -1, -1}, Vec3f{1, -1, 1}}) {
    const Camera camera({}, up, up, 35, {2, 2});
    EXPECT_LT(dot(camera.direction(0, 0), camera.direction(1, 0)), 0.97f);
    EXPECT_LT(dot(camera.direction(0, 0), camera.direction(0, 1)), 0.97f);
  }
}

TEST(Camera, DescriptionIsTheSameViewFarFromTheOrigin) {
  const Camera camera({431234.56f, 5412345.5f, 120.123f}, {431200.1f, 5412300.5f, 1e-7f}, {0, 0, 1}, 35.1f, {64, 48});
  const Camera read = parseView(camera.description(), {0, 0, 1}, {64, 48});
  EXPECT_EQ(length(read.eye() - camera.eye()), 0.0f) << camera.description();
  EXPECT_EQ(length(read.lookAt() - camera.lookAt()), 0.0f);
  EXPECT_EQ(read.fov(), camera.fov());
}

}} // namespace programs::test
