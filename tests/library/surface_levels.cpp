// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares levels 1 to 8 with GRID, at every frame level up to the level. */

#include "support/grid_agreement.h"

namespace programs::test { namespace {

void compare(Device& device, const Cage& cage, unsigned level, int frameLevel) {
  Random random(42);
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = float(1u << level);
  const std::vector<RTCRayHit> rays = raysAt(random, 300);
  settings.compression = RTC_COMPRESSION_NONE;
  const SurfaceScene grid(device, cage, settings);
  for (RTCCompression compression :
       {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT}) {
    SCOPED_TRACE(testing::Message() << "compression " << compression << ", level " << level << ", frame level "
                                    << frameLevel);
    settings.compression = compression;
    settings.frameLevel = frameLevel;
    const SurfaceScene scene(device, cage, settings);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = statisticsOf(scene);
    ASSERT_GT(stats.numQuads, 0u);
    EXPECT_EQ(stats.numUncompressedQuads, 0u);
    EXPECT_EQ(stats.numInvalidQuads, 0u);
    if (compression == RTC_COMPRESSION_CGRID) expectEqualToGrid(grid, scene, rays, cage);
    else expectCloseToGrid(grid, scene, rays, cage, settings);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(SurfaceLevels, EveryLevelAndFrameLevelMatchesGrid) {
  Device device;
  Cage cage = sheetCage(1);
  cage.mode = RTC_SUBDIVISION_MODE_PIN_CORNERS;
  for (unsigned level = 1; level <= 8; level++)
    for (int frameLevel = 0; frameLevel <= int(level); frameLevel++) {
      compare(device, cage, level, frameLevel);
      if (HasFatalFailure()) return;
    }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// A frame level beyond the level gives one quad per block.
TEST(SurfaceLevels, FrameLevelsPastTheLevelAreClamped) {
  Device device;
  Displacement displacement;
  for (unsigned level : {0, 1, 3}) {
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = float(1u << level);
    settings.compression = RTC_COMPRESSION_CLEAF;
    settings.frameLevel = 8;
    const SurfaceScene scene(device, cubeCage(), settings);
    EXPECT_EQ(statisticsOf(scene).numBlocks, 6 * (size_t(1) << (2 * level)));
    EXPECT_EQ(statisticsOf(scene).numQuads, 6 * (size_t(1) << (2 * level)));
  }
}

// Orientation of corners in blocks of one quad: cLEAF splits the quad into four leaves. Their middle planes are
// multiples of 1/64, so the error of parameters is at most half of that.
TEST(SurfaceLevels, SingleQuadBlocksHaveParametersOfTheirFace) {
  Device device;
  for (RTCCompression compression : {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF})
    for (unsigned level : {0, 2}) {
      SCOPED_TRACE(testing::Message() << "compression " << compression << ", level " << level);
      Random random(43);
      SurfaceSettings settings;
      settings.rate = float(1u << level);
      settings.compression = compression;
      settings.frameLevel = int(level);
      const SurfaceScene scene(device, quadCage(), settings);
      EXPECT_EQ(statisticsOf(scene).numBlocks, size_t(1) << (2 * level));
      for (int i = 0; i < 500; i++) {
        const float x = float(random.uniform(0.01, 0.99)), y = float(random.uniform(0.01, 0.99));
        const RTCRayHit hit = intersect(scene, makeRay({x, y, 1}, {0, 0, -1}));
        ASSERT_TRUE(isHit(hit)) << x << ", " << y;
        ASSERT_NEAR(hit.hit.u, x, 0.01f / settings.rate);
        ASSERT_NEAR(hit.hit.v, y, 0.01f / settings.rate);
      }
    }
}

}} // namespace programs::test
