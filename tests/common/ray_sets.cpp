// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/ray_sets.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <set>

namespace programs::test { namespace {

std::vector<Ray> numbered(ImageSize size) {
  std::vector<Ray> rays(size_t(size.width) * size.height);
  for (size_t i = 0; i < rays.size(); i++) rays[i].origin.x = float(i);
  return rays;
}

TEST(RaySets, CoherentRaysAreInTilesAndCoverThePicture) {
  const ImageSize size{19, 13}; // not a multiple of 8
  const std::vector<Ray> rays = coherentRays(numbered(size), size, 0);
  ASSERT_EQ(rays.size(), size_t(19 * 13));
  std::set<float> seen;
  for (const Ray& r : rays) seen.insert(r.origin.x);
  EXPECT_EQ(seen.size(), rays.size());
  EXPECT_EQ(rays[7].origin.x, 7.0f);
  EXPECT_EQ(rays[8].origin.x, 19.0f) << "the second row of the first tile";
}

TEST(RaySets, FewerCoherentRaysAreWholeTiles) {
  const ImageSize size{64, 64};
  EXPECT_EQ(coherentRays(numbered(size), size, 1000).size(), size_t(16 * 64));
  EXPECT_EQ(coherentRays(numbered(size), size, SIZE_MAX).size(), size_t(64 * 64));
}

TEST(RaySets, BouncesStartOffTheSurfaceOnTheCamerasSide) {
  std::vector<Ray> primary(1000);
  std::vector<SurfaceHit> hits(1000);
  for (size_t i = 0; i < primary.size(); i++) {
    primary[i].direction = {0, 0, -1};
    hits[i].t = 4.0f;
    hits[i].face = 0;
    hits[i].normal = {0, 0, i % 2 ? 3.0f : -3.0f};
  }
  hits[7] = SurfaceHit();
  BounceSettings settings;
  settings.offset = 0.25f;
  const std::vector<Ray> rays = bounceRays(primary, hits, settings);
  ASSERT_EQ(rays.size(), 999u) << "misses have no bounce";
  double cosine = 0;
  for (const Ray& r : rays) {
    EXPECT_EQ(r.origin.z, -3.75f);
    EXPECT_GE(r.direction.z, 0.0f);
    EXPECT_NEAR(length(r.direction), 1.0f, 1e-5f);
    cosine += r.direction.z;
  }
  EXPECT_NEAR(cosine / 999, 2.0 / 3.0, 0.03) << "mean cosine of a cosine distribution";
}

TEST(RaySets, BouncesAreTheSameForTheSameSeed) {
  std::vector<Ray> primary(100);
  std::vector<SurfaceHit> hits(100);
  for (size_t i = 0; i < primary.size(); i++) {
    primary[i].direction = {0, 0, -1};
    hits[i].t = float(i + 1);
    hits[i].normal = {0, 0, 1};
  }
  const auto a = bounceRays(primary, hits, {}), b = bounceRays(primary, hits, {});
  BounceSettings other;
  other.seed = 2;
  const auto c = bounceRays(primary, hits, other);
  ASSERT_EQ(a.size(), 100u);
  ASSERT_EQ(b.size(), 100u);
  ASSERT_EQ(c.size(), 100u);
  size_t same = 0;
  for (size_t i = 0; i < a.size(); i++) {
    EXPECT_EQ(a[i].direction.x, b[i].direction.x);
    EXPECT_EQ(a[i].origin.z, b[i].origin.z);
    same += a[i].origin.z == c[i].origin.z;
  }
  EXPECT_LT(same, 20u);
}

}} // namespace programs::test
