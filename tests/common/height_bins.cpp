// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Bins on a plane: a flat square, displaced by a slope, has bins in closed form. */

#include "measure/height_bins.h"

#include <gtest/gtest.h>

namespace cbvh::test {
namespace {

constexpr int level = 4;
constexpr float width = 8.0f, footprint = 1.0f / 64.0f, distance = 4.0f;

struct Slope : Displacement
{
  explicit Slope(float rise) : rise(rise) {}
  void offsets(const SurfacePoints& points, float* offsets) const override
  {
    for (size_t i = 0; i < points.n; i++)
      offsets[i] = rise * points.u[i];
  }
  const float rise; // from u = 0 to 1
};

Model plane(float rise, Placement placement = {})
{
  Model model;
  model.cage.positions = {{0, 0, 0}, {width, 0, 0}, {width, width, 0}, {0, width, 0}};
  model.cage.faceSizes = {4};
  model.cage.faceIndices = {0, 1, 2, 3};
  model.cage.boundary = BoundaryRule::EdgeAndCorner;
  model.displacement = std::make_shared<Slope>(rise);
  model.copies = {placement};
  return model;
}

/* Of one ray with a direction that meets the middle of the plane. */
HeightBins bins(const Model& model, Vec3f direction, int frameLevel)
{
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

/* A bin of the box of one of 16 x 16 quads, in pixels. */
constexpr double binOf(double rise)
{
  return rise / 16 / 16 / (footprint * distance);
}

TEST(HeightBins, OfASlopeSeenAlongZAreASixteenthOfAQuadsRise)
{
  for (int frameLevel : {0, 2, 4})
  {
    const HeightBins b = bins(plane(12), {0, 0, -1}, frameLevel);
    EXPECT_EQ(b.hits, 1u);
    for (double q : b.quantiles)
      EXPECT_NEAR(q, binOf(12), 1e-5);
  }
}

TEST(HeightBins, ErrorsAreEvenWithinHalfABin)
{
  const HeightBins b = bins(plane(12), {0, 0, -1}, 2);
  EXPECT_NEAR(b.inlierRmse, binOf(12) / std::sqrt(12.0), 1e-5);
  EXPECT_NEAR(b.median, binOf(12) / 4, binOf(12) / 2 / 20);
}

TEST(HeightBins, AlongASlantingRayAPlaneMovesByItsNormal)
{
  const Vec3d d = normalize(Vec3d{0.5, 0.25, -1}), n = {-12 / width, 0, 1};
  EXPECT_NEAR(bins(plane(12), {0.5f, 0.25f, -1}, 2).quantiles[9], binOf(12) / -dot(d, n), 1e-5);
}

TEST(HeightBins, OfACopyGrowWithIt)
{
  Placement copy;
  copy.scale = 3;
  copy.angle = 2;
  const Vec3d down = {-std::sin(2.0), 0, -std::cos(2.0)}; // against the turned z axis
  const Vec3f direction{float(down.x), float(down.y), float(down.z)};
  EXPECT_NEAR(bins(plane(12, copy), direction, 2).quantiles[9], 3 * binOf(12), 1e-4);
}

TEST(HeightBins, ErrorsBeyond5PixelsStayOutOfTheRmse)
{
  const HeightBins b = bins(plane(480), {0, 0, -1}, 2);
  ASSERT_GT(binOf(480), 2 * 5.0);
  EXPECT_NEAR(b.inlierRmse, 5 / std::sqrt(3.0), 1e-5);
  EXPECT_NEAR(b.median, binOf(480) / 4, binOf(480) / 2 / 20);
}

TEST(HeightBins, OfAFlatSurfaceAreNothing)
{
  const HeightBins b = bins(plane(0), {0, 0, -1}, 2);
  EXPECT_EQ(b.hits, 1u);
  EXPECT_EQ(b.quantiles[9], 0.0);
  EXPECT_EQ(b.inlierRmse, 0.0);
}

} // namespace
} // namespace cbvh::test
