// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Every level and frame level that can be compressed against GRID, and what is left to
 * GRID. */

#include "grid_agreement.h"

namespace cbvh {
namespace {

void compare(Device& device, const Cage& cage, unsigned level, int frameLevel, unsigned numRays, uint32_t seed)
{
  Random random(seed);
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = float(1u << level);
  const std::vector<RTCRayHit> rays = raysAt(random, numRays);
  Scene grid(device);
  settings.compression = RTC_COMPRESSION_NONE;
  addSurface(device, grid, cage, settings);
  rtcCommitScene(grid);
  for (RTCCompression compression : {RTC_COMPRESSION_GRID, RTC_COMPRESSION_VOXEL, RTC_COMPRESSION_LEAF}) {
    SCOPED_TRACE(testing::Message() << "compression " << compression << ", level " << level << ", frame level " << frameLevel);
    Scene scene(device);
    settings.compression = compression;
    settings.frameLevel = frameLevel;
    addSurface(device, scene, cage, settings);
    rtcCommitScene(scene);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = statisticsOf(scene);
    ASSERT_GT(stats.numQuads, 0u);
    EXPECT_EQ(stats.numGridQuads, 0u);
    EXPECT_EQ(stats.numInvalidQuads, 0u);
    if (compression == RTC_COMPRESSION_GRID) expectEqualToGrid(grid, scene, rays, cage);
    else expectCloseToGrid(grid, scene, rays, compression, settings.rate, cage, displacement);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(SurfaceLevels, EveryLevelAndFrameLevelIsFoundAsGridFindsIt)
{
  Device device;
  Cage cage = sheetCage(1);
  cage.mode = RTC_SUBDIVISION_MODE_PIN_CORNERS;
  for (unsigned level = 1; level <= 8; level++)
    for (int frameLevel = 0; frameLevel <= int(level); frameLevel++) {
      compare(device, cage, level, frameLevel, 300, 42);
      if (HasFatalFailure()) return;
    }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// A frame level past the level leaves one quad a block.
TEST(SurfaceLevels, FrameLevelsPastTheLevelAreClamped)
{
  Device device;
  Displacement displacement;
  for (unsigned level : {0, 1, 3}) {
    Scene scene(device);
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = float(1u << level);
    settings.compression = RTC_COMPRESSION_LEAF;
    settings.frameLevel = 8;
    addSurface(device, scene, cubeCage(), settings);
    rtcCommitScene(scene);
    EXPECT_EQ(statisticsOf(scene).numBlocks, 6*(size_t(1) << (2*level)));
    EXPECT_EQ(statisticsOf(scene).numQuads, 6*(size_t(1) << (2*level)));
  }
}

// --- what is traced by GRID --------------------------------------------------------------

// The same surface in a scene that compresses and in one that does not; levels of all
// edges when given.
void compareUncompressed(float rate, const std::vector<float>& edgeRates, bool compressed, const char* says, unsigned timeSteps = 1)
{
  Random random(43);
  Displacement displacement;
  std::vector<RTCRayHit> rays = raysAt(random, 1500);
  for (RTCRayHit& ray : rays) ray.ray.time = float(random.uniform());
  Device stock;
  for (const char* kind : {"grid", "voxel", "leaf"}) {
    SCOPED_TRACE(testing::Message() << kind << ", rate " << rate << ", " << edgeRates.size() << " edge rates");
    testing::internal::CaptureStdout();
    Device device(std::string("verbose=1,subdiv_accel=cbvh.") + kind);
    Scene a(stock), b(device);
    for (int i = 0; i < 2; i++) {
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.rate = rate;
      settings.timeSteps = timeSteps;
      RTCDevice owner = i ? device : stock;
      settings.edgeRates = edgeRates;
      addSurface(owner, i ? b : a, cubeCage(), settings);
      rtcCommitScene(i ? b : a);
    }
    const std::string output = testing::internal::GetCapturedStdout();
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = statisticsOf(b);
    EXPECT_EQ(stats.numQuads != 0, compressed);
    if (*says) { EXPECT_NE(output.find(says), std::string::npos) << output; }
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
    EXPECT_GT(hits, rays.size()/4);
  }
}

TEST(UncompressedSurfaces, RatesAbove256EqualStock)
{
  std::vector<float> rates;
  for (unsigned i = 0; i < 24; i++) rates.push_back(i % 4 == 1 ? 257 : float(1 + (i*7)%12));
  compareUncompressed(4, rates, false, "traced by GRID");
}

TEST(UncompressedSurfaces, MotionBlurEqualsStock)
{
  compareUncompressed(8, {}, false, "motion blur: traced by GRID", 2);
}

// Compressed faces beside others, in one BVH.
TEST(UncompressedSurfaces, FacesOfTooHighRatesLiveBesideCompressedOnes)
{
  Device device;
  Displacement displacement;
  Random random(44);
  std::vector<float> rates(24, 16.0f);
  for (int i = 0; i < 4; i++) rates[i] = 300; // face 0; its neighbours' edges keep their own
  Scene scene(device), grid(device);
  for (int i = 0; i < 2; i++) {
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = i ? RTC_COMPRESSION_GRID : RTC_COMPRESSION_NONE;
    settings.frameLevel = 1;
    settings.edgeRates = rates;
    addSurface(device, i ? scene : grid, cubeCage(), settings);
    rtcCommitScene(i ? scene : grid);
  }
  const RTCCompressionStatistics stats = statisticsOf(scene);
  EXPECT_GT(stats.numQuads, 0u);
  EXPECT_GT(stats.numGridQuads, 0u);
  EXPECT_GT(stats.gridBytes, 0u);
  expectEqualToGrid(grid, scene, raysAt(random, 3000), cubeCage());
}

} // namespace
} // namespace cbvh
