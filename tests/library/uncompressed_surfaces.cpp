// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Surfaces that are not compressed are left to GRID, with the results of a device that does not compress. */

#include "support/grid_agreement.h"
#include "support/message_parts.h"

namespace programs::test { namespace {

// edgeRates: levels of all edges, if not empty.
void compareUncompressed(float rate, const std::vector<float>& edgeRates, bool compressed,
                         const std::vector<std::string>& lineParts, unsigned timeSteps = 1) {
  Random random(43);
  Displacement displacement;
  std::vector<RTCRayHit> rays = raysAt(random, 1500);
  for (RTCRayHit& ray : rays) ray.ray.time = float(random.uniform());
  Device stock;
  for (const char* kind : {"grid", "voxel", "leaf"}) {
    SCOPED_TRACE(testing::Message() << kind << ", rate " << rate << ", " << edgeRates.size() << " edge rates");
    testing::internal::CaptureStderr();
    Device device(std::string("verbose=1,cbvh_fallback_faces=0,subdiv_accel=cbvh.") + kind);
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = rate;
    settings.timeSteps = timeSteps;
    settings.edgeRates = edgeRates;
    const SurfaceScene a(stock, cubeCage(), settings), b(device, cubeCage(), settings);
    const std::string output = testing::internal::GetCapturedStderr();
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = statisticsOf(b);
    EXPECT_EQ(stats.numQuads != 0, compressed);
    EXPECT_TRUE(containsInOrder(lineWith(output, lineParts[0]), lineParts)) << output;
    unsigned hits = 0;
    for (const RTCRayHit& ray : rays) {
      const RTCRayHit x = intersect(a, ray), y = intersect(b, ray);
      ASSERT_EQ(isHit(x), isHit(y));
      ASSERT_EQ(occluded(b, ray), occluded(a, ray));
      if (!isHit(x)) continue;
      hits++;
      ASSERT_EQ(x.ray.tfar, y.ray.tfar);
      ASSERT_EQ(x.hit.primID, y.hit.primID);
      ASSERT_EQ(x.hit.u, y.hit.u);
      ASSERT_EQ(x.hit.v, y.hit.v);
    }
    EXPECT_GT(hits, rays.size() / 4);
  }
}

TEST(UncompressedSurfaces, RatesAbove256MatchStock) {
  std::vector<float> rates;
  for (unsigned i = 0; i < 24; i++) rates.push_back(i % 4 == 1 ? 257 : float(1 + (i * 7) % 12));
  compareUncompressed(4, rates, false, {" 256 ", " GRID"});
}

TEST(UncompressedSurfaces, MotionBlurMatchesStock) {
  compareUncompressed(8, {}, false, {" 6 faces ", "motion", "fallback_faces=1"}, 2);
}

TEST(UncompressedSurfaces, FacesWithHighRatesCoexistWithCompressedOnes) {
  Device device;
  Displacement displacement;
  Random random(44);
  std::vector<float> rates(24, 16.0f);
  for (int i = 0; i < 4; i++) rates[i] = 300; // face 0; the edges of its neighbors keep their rates
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CGRID;
  settings.frameLevel = 1;
  settings.edgeRates = rates;
  const Twins twins(device, cubeCage(), settings);
  const RTCCompressionStatistics stats = statisticsOf(twins.scene);
  EXPECT_GT(stats.numQuads, 0u);
  EXPECT_GT(stats.numUncompressedQuads, 0u);
  EXPECT_GT(stats.uncompressedBytes, 0u);
  expectEqualToGrid(twins.grid, twins.scene, raysAt(random, 3000), cubeCage());
}

}} // namespace programs::test
