// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Bins on a flat square that is displaced by a slope; their size has a closed form. */

#include "measure/height_bins.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

constexpr int level = 4;
constexpr float width = 8.0f, footprint = 1.0f / 64.0f, distance = 4.0f;

struct Slope : Displacement {
  explicit Slope(float rise) : rise(rise) {}
  void offsets(const SurfacePoints& points, float* offsets) const override {
    for (size_t i = 0; i < points.n; i++) offsets[i] = rise * points.u[i];
  }
  const float rise; // height difference between u = 0 and 1
};

Model plane(float rise, Placement placement = {}) {
  Model model;
  model.cage.positions = {{0, 0, 0}, {width, 0, 0}, {width, width, 0}, {0, width, 0}};
  model.cage.faceSizes = {4};
  model.cage.faceIndices = {0, 1, 2, 3};
  model.cage.boundary = BoundaryRule::EdgeAndCorner;
  model.displacement = std::make_shared<Slope>(rise);
  model.copies = {placement};
  return model;
}

/* Bins of one ray with this direction through the center of the plane. */
HeightBins bins(const Model& model, Vec3f direction, int frameLevel) {
  const TrueSurfaces surfaces(model);
  SurfaceHit hit;
  hit.t = distance;
  hit.face = 0;
  hit.u = hit.v = 0.53f;
  Ray ray;
  ray.direction = normalize(direction);
  const std::vector<Ray> rays = {ray};
  return heightBins({model, surfaces, rays, {0}, footprint}, {hit}, {model.layout(level), level, frameLevel}, 1);
}

/* Size of a bin of a quad's box, of 16 x 16 quads, in pixels. */
constexpr double binOf(double rise) { return rise / 16 / 16 / (footprint * distance); }

TEST(HeightBins, OnSlopeAlongZAreASixteenthOfAQuadsRise) {
  for (int frameLevel : {0, 2, 4}) {
    const HeightBins b = bins(plane(12), {0, 0, -1}, frameLevel);
    EXPECT_EQ(b.hits, 1u);
    for (double q : b.quantiles) EXPECT_NEAR(q, binOf(12), 1e-5);
  }
}

TEST(HeightBins, ErrorsAreUniformWithinHalfABin) {
  const HeightBins b = bins(plane(12), {0, 0, -1}, 2);
  EXPECT_NEAR(b.inlierRmse, binOf(12) / std::sqrt(12.0), 1e-5);
  EXPECT_NEAR(b.median, binOf(12) / 4, binOf(12) / 2 / 20);
}

TEST(HeightBins, SlantingRayOnPlaneMovesAlongItsNormal) {
  const Vec3d d = normalize(Vec3d{0.5, 0.25, -1}), n = {-12 / width, 0, 1};
  EXPECT_NEAR(bins(plane(12), {0.5f, 0.25f, -1}, 2).quantiles[9], binOf(12) / -dot(d, n), 1e-5);
}

TEST(HeightBins, ScaleWithCopies) {
  Placement copy;
  copy.scale = 3;
  copy.angle = 2;
  const Vec3d down = {-std::sin(2.0), 0, -std::cos(2.0)}; // opposite to the rotated z axis
  const Vec3f direction{float(down.x), float(down.y), float(down.z)};
  EXPECT_NEAR(bins(plane(12, copy), direction, 2).quantiles[9], 3 * binOf(12), 1e-4);
}

TEST(HeightBins, ErrorsBeyond5PixelsAreNotInTheRmse) {
  const HeightBins b = bins(plane(480), {0, 0, -1}, 2);
  ASSERT_GT(binOf(480), 2 * 5.0);
  EXPECT_NEAR(b.inlierRmse, 5 / std::sqrt(3.0), 1e-5);
  EXPECT_NEAR(b.median, binOf(480) / 4, binOf(480) / 2 / 20);
}

TEST(HeightBins, OnFlatSurfaceAreZero) {
  const HeightBins b = bins(plane(0), {0, 0, -1}, 2);
  EXPECT_EQ(b.hits, 1u);
  EXPECT_EQ(b.quantiles[9], 0.0);
  EXPECT_EQ(b.inlierRmse, 0.0);
}

/* The diagonals of the only block are parallel, but those of its quads are not. */
TEST(HeightBins, BlocksWithoutNormalHaveNone) {
  Model model = plane(12);
  model.cage.positions = {{0, 0, 0}, {width, 0, 0}, {width, width, 0}, {2 * width, width, 0}};
  EXPECT_EQ(bins(model, {0, 0, -1}, 0).hits, 0u);
  EXPECT_EQ(bins(model, {0, 0, -1}, 4).hits, 1u);
}

}} // namespace programs::test
