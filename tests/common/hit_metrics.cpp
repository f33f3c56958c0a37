// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/hit_metrics.h"
#include "scenes/cube.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

SurfaceHit hitAt(float t, unsigned face = 0, float u = 0.5f, float v = 0.5f, Vec3f normal = {0, 0, 2}) {
  SurfaceHit hit;
  hit.t = t;
  hit.face = face;
  hit.u = u;
  hit.v = v;
  hit.normal = normal;
  return hit;
}

const SurfaceHit miss;
const PatchLayout layout(makeCube().cage, 4);

TEST(HitMetrics, DistanceIsInFootprintsAtTheReference) {
  const HitErrors e = compareHits({hitAt(10), hitAt(20)}, {hitAt(10.3f), hitAt(19.2f)}, 0.01f, layout);
  EXPECT_EQ(e.bothHit, 2u);
  EXPECT_NEAR(e.max, 4.0, 1e-4); // 0.8 / (0.01 * 20)
  EXPECT_NEAR(e.median, 3.0, 1e-4);
  EXPECT_NEAR(e.rmse, std::sqrt((9.0 + 16.0) / 2), 1e-4);
}

TEST(HitMetrics, FalseHitsAndMissesAreNotInTheDistances) {
  const HitErrors e = compareHits({miss, hitAt(10), hitAt(10), miss}, {hitAt(1), miss, hitAt(10), miss}, 0.01f, layout);
  EXPECT_EQ(e.falseHits, 1u);
  EXPECT_EQ(e.misses, 1u);
  EXPECT_EQ(e.bothHit, 1u);
  EXPECT_EQ(e.rmse, 0.0);
  EXPECT_EQ(pixelErrors({miss, hitAt(10), hitAt(10), miss}, {hitAt(1), miss, hitAt(10), miss}, 0.01f),
            (std::vector<float>{falseHitError, missError, 0.0f, backgroundError}));
}

TEST(HitMetrics, DistantHitsAreCountedAndNotInTheSecondRmse) {
  const HitErrors e = compareHits({hitAt(10), hitAt(10)}, {hitAt(10.1f), hitAt(15)}, 0.01f, layout);
  EXPECT_EQ(e.outliers, 1u);
  EXPECT_NEAR(e.inlierRmse, 1.0, 1e-4);
  EXPECT_GT(e.rmse, 30.0);
}

TEST(HitMetrics, FlippedNormalIs180Degrees) {
  const HitErrors e = compareHits({hitAt(10)}, {hitAt(10, 0, 0.5f, 0.5f, {0, 0, -3})}, 0.01f, layout);
  EXPECT_NEAR(e.normalMedian, 180.0, 1e-3);
}

TEST(HitMetrics, NormalsOfAnyLengthAreCompared) {
  for (float length : {1e-37f, 1e-22f, 1e-18f, 1.0f, 1e19f, 1e38f}) {
    const SurfaceHit tilted = hitAt(10, 0, 0.5f, 0.5f, {0, length, length});
    const HitErrors e = compareHits({hitAt(10, 0, 0.5f, 0.5f, {0, 0, length})}, {tilted}, 0.01f, layout);
    EXPECT_NEAR(e.normalMedian, 45.0, 1e-3) << length;
  }
}

TEST(HitMetrics, ParametersAreComparedInCellsOfTheSamePatch) {
  const HitErrors e = compareHits({hitAt(10), hitAt(10)}, {hitAt(10, 0, 0.5f, 0.625f), hitAt(10, 1)}, 0.01f, layout);
  EXPECT_NEAR(e.uvMedian, 2.0, 1e-5); // 0.125 * 16
  EXPECT_EQ(e.otherPatch, 1u);
}

TEST(HitMetrics, ParametersOfPolygonsAreComparedInTheirCornerQuad) {
  Cage pentagon;
  pentagon.faceSizes = {5};
  const PatchLayout corners(pentagon, 4);
  /* Corners 1 and 4: (2.5..3.5, 0.5..1.5) and (0.5..1.5, 2.5..3.5), 8 x 8 cells each. */
  const HitErrors e = compareHits({hitAt(10, 0, 2.75f, 0.75f), hitAt(10, 0, 2.75f, 0.75f)},
                                  {hitAt(10, 0, 3.0f, 0.75f), hitAt(10, 0, 0.75f, 2.75f)}, 0.01f, corners);
  EXPECT_NEAR(e.uvMedian, 2.0, 1e-5);
  EXPECT_EQ(e.otherPatch, 1u);
}

TEST(HitMetrics, NearerHitsUseTheSmallerDistanceAndAnyHit) {
  const auto n = nearerHits({hitAt(10), hitAt(9), miss}, {hitAt(8), miss, hitAt(3)});
  EXPECT_EQ(n[0].t, 8.0f);
  EXPECT_EQ(n[1].t, 9.0f);
  EXPECT_EQ(n[2].t, 3.0f);
}

}} // namespace programs::test
