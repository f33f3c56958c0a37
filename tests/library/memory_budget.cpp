// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The setting memory: scenes choose between tiles and cVERT within a limit for the device, with the same hits. */

#include "support/environment.h"
#include "support/same_hits.h"
#include "support/saved.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>

namespace programs::test { namespace {

constexpr uint32_t seed = 33;

std::string limitOf(size_t bytes) { return "subdiv_accel=cbvh,cbvh_memory=" + std::to_string(bytes); }

size_t bytesOf(RTCScene scene) {
  const RTCCompressionStatistics s = statisticsOf(scene);
  return s.topLevelBytes + s.headerBytes + s.nodeBytes + s.leafBytes + s.uncompressedBytes;
}

// Surfaces of different size and position on a device, and a scene of them.
struct Bodies {
  Device device;
  Scene scene;
  std::vector<Displacement> displacements;

  explicit Bodies(const std::string& config, size_t count = 6) : device(config), scene(device), displacements(count) {
    for (size_t i = 0; i < count; i++) {
      displacements[i].scale = 0.1f + 0.05f * float(i);
      displacements[i].offset = {2.0f * float(i) / float(count) - 1, 0.3f * float(i % 3), 0};
      set(i, 16 + 9 * float(i % 4));
    }
  }

  // Adds the surface, or replaces it.
  void set(size_t i, float rate) {
    SurfaceSettings settings;
    settings.displacement = &displacements[i];
    settings.rate = rate;
    if (i < ids.size()) {
      rtcDetachGeometry(scene, ids[i]);
      ids[i] = addSurface(device, scene, cubeCage(), settings);
    } else ids.push_back(addSurface(device, scene, cubeCage(), settings));
  }

  // Returns the bytes of the committed scene.
  size_t commit() {
    rtcCommitScene(scene);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    return bytesOf(scene);
  }

private:
  std::vector<unsigned> ids;
};

void expectSameHits(RTCScene a, RTCScene b) {
  Random random(seed);
  const std::vector<RTCRayHit> some = raysAt(random, 2000), expected = closestHits(a, some, QueryForm::Single),
                               found = closestHits(b, some, QueryForm::Single);
  size_t hits = 0;
  for (size_t i = 0; i < some.size(); i++) {
    hits += isHit(expected[i]);
    ASSERT_EQ(std::memcmp(&expected[i], &found[i], sizeof(RTCRayHit)), 0) << "ray " << i;
  }
  EXPECT_GT(hits, 100u);
}

// Bytes of the least and of the greatest form.
struct Extremes {
  size_t blocks, tiles;

  Extremes() : blocks(Bodies("subdiv_accel=cbvh.vert").commit()), tiles(Bodies("subdiv_accel=cbvh.tile").commit()) {}
};

TEST(MemoryBudget, AsManyTilesAsFit) {
  const Extremes extremes;
  ASSERT_GT(extremes.tiles, extremes.blocks);
  Bodies blocks("subdiv_accel=cbvh.vert");
  blocks.commit();
  size_t before = 0;
  for (int percent : {0, 20, 40, 60, 80, 120, 1000}) {
    SCOPED_TRACE(testing::Message() << percent << " percent of what tiles add");
    const size_t limit = extremes.blocks + (extremes.tiles - extremes.blocks) * size_t(percent) / 100;
    Bodies bodies(limitOf(limit));
    const size_t bytes = bodies.commit();
    EXPECT_LE(bytes, limit);
    EXPECT_GE(bytes, before);
    if (percent == 0) EXPECT_EQ(bytes, extremes.blocks);
    if (percent == 60) EXPECT_GT(bytes, extremes.blocks);
    if (percent == 1000) EXPECT_EQ(bytes, extremes.tiles);
    before = bytes;
    ASSERT_NO_FATAL_FAILURE(expectSameHits(blocks.scene, bodies.scene));
  }
}

TEST(MemoryBudget, AnErrorNamesTheLeastLimit) {
  const Extremes extremes;
  const std::string needed = std::to_string(extremes.blocks);
  for (size_t limit : {size_t(1), extremes.blocks - 1}) {
    Bodies bodies(limitOf(limit));
    rtcCommitScene(bodies.scene);
    EXPECT_EQ(bodies.device.takeError(), RTC_ERROR_OUT_OF_MEMORY);
    EXPECT_NE(bodies.device.message.find("need at least " + needed + " bytes"), std::string::npos)
        << bodies.device.message;
  }
  Bodies(limitOf(extremes.blocks)).commit();
}

// Whatever is edited, the limit holds, and what fits again becomes tiles again.
TEST(MemoryBudget, Edits) {
  const Extremes extremes;
  Bodies largest("subdiv_accel=cbvh.vert");
  for (size_t i : {0, 3}) largest.set(i, 60.0f);
  const size_t limit = largest.commit() * 6 / 5;
  Bodies bodies(limitOf(limit)), blocks("subdiv_accel=cbvh.vert");
  const size_t first = bodies.commit();
  for (float rate : {40.0f, 60.0f, 16.0f}) {
    for (size_t i : {0, 3}) {
      bodies.set(i, rate);
      blocks.set(i, rate);
    }
    EXPECT_LE(bodies.commit(), limit);
    blocks.commit();
    ASSERT_NO_FATAL_FAILURE(expectSameHits(blocks.scene, bodies.scene));
  }
  EXPECT_GT(first, extremes.blocks);
  EXPECT_GT(bodies.commit(), blocks.commit());
}

// Scenes of a device share its limit, and surfaces.
TEST(MemoryBudget, ScenesOfADevice) {
  const Extremes extremes;
  Bodies bodies(limitOf(extremes.tiles + extremes.tiles / 4));
  ASSERT_EQ(bodies.commit(), extremes.tiles);
  SurfaceSettings settings;
  settings.rate = 48;
  {
    Scene second(bodies.device);
    const RTCGeometry geometry = newSurface(bodies.device, cubeCage(), settings);
    attach(second, geometry);
    rtcCommitScene(second);
    ASSERT_EQ(bodies.device.takeError(), RTC_ERROR_NONE) << bodies.device.message;
    EXPECT_LE(bytesOf(second) + bytesOf(bodies.scene), extremes.tiles + extremes.tiles / 4);
  }
  settings.rate = 16;
  Scene third(bodies.device);
  attach(third, newSurface(bodies.device, cubeCage(), settings));
  rtcCommitScene(third);
  ASSERT_EQ(bodies.device.takeError(), RTC_ERROR_NONE) << bodies.device.message;
  Device other("subdiv_accel=cbvh.tile");
  Scene tiles(other);
  attach(tiles, newSurface(other, cubeCage(), settings));
  rtcCommitScene(tiles);
  EXPECT_EQ(bytesOf(third), bytesOf(tiles)) << "the second scene's memory was not given back";
}

// Surfaces of files stay there unless tiles fit, and return.
TEST(MemoryBudget, Files) {
  const Folder folder;
  Device device("subdiv_accel=cbvh.vert");
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = 90;
  const RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  Scene blocks(device);
  attach(blocks, geometry);
  rtcCommitScene(blocks);
  const std::string path = folder / "surface";
  ASSERT_TRUE(saveGeometryFile(geometry, path.c_str())) << cbvhGetErrorText();
  for (bool fits : {true, false}) {
    Device limited(limitOf(fits ? 4 * bytesOf(blocks) : bytesOf(blocks) / 2)); // mapped blocks do not count
    Scene loaded(limited);
    attach(loaded, loadGeometryFile(limited, path.c_str()));
    rtcCommitScene(loaded);
    ASSERT_EQ(limited.takeError(), RTC_ERROR_NONE) << limited.message;
    if (fits) EXPECT_GT(bytesOf(loaded), bytesOf(blocks));
    else EXPECT_EQ(bytesOf(loaded), bytesOf(blocks));
    ASSERT_NO_FATAL_FAILURE(expectSameHits(blocks, loaded));
    if (!fits) continue;
    SurfaceSettings further; // takes the room of the tiles
    further.displacement = &displacement;
    further.rate = 140;
    further.compression = RTC_COMPRESSION_CVERT;
    addSurface(limited, loaded, cubeCage(), further);
    rtcCommitScene(loaded);
    ASSERT_EQ(limited.takeError(), RTC_ERROR_NONE) << limited.message;
    Scene both(device);
    attach(both, newSurface(device, cubeCage(), settings));
    addSurface(device, both, cubeCage(), further);
    rtcCommitScene(both);
    EXPECT_EQ(bytesOf(loaded), bytesOf(both)) << "the surface did not return to its file";
  }
}

// Blocks of few quads, and those of moving surfaces, stay in their file, whose bytes do not count.
TEST(MemoryBudget, FilesWithoutTiles) {
  const Folder folder;
  Device device("subdiv_accel=cbvh.vert");
  for (bool moves : {false, true}) {
    SurfaceSettings settings;
    settings.rate = moves ? 90.0f : 7.0f;
    settings.timeSteps = moves ? 3 : 1;
    const RTCGeometry geometry = newSurface(device, cubeCage(), settings);
    Scene blocks(device);
    attach(blocks, geometry);
    rtcCommitScene(blocks);
    const std::string path = folder / (moves ? "moving" : "small");
    ASSERT_TRUE(saveGeometryFile(geometry, path.c_str())) << cbvhGetErrorText();
    const RTCCompressionStatistics s = statisticsOf(blocks);
    Device limited(limitOf(s.topLevelBytes + s.leafBytes / 2));
    Scene loaded(limited);
    attach(loaded, loadGeometryFile(limited, path.c_str()));
    rtcCommitScene(loaded);
    EXPECT_EQ(limited.takeError(), RTC_ERROR_NONE) << limited.message;
    EXPECT_EQ(bytesOf(loaded), bytesOf(blocks));
    ASSERT_NO_FATAL_FAILURE(expectSameHits(blocks, loaded));
  }
}

TEST(MemoryBudget, Values) {
  for (const char* value : {"1", "512M", "512m", "1.5G", "2K", "123456789"}) {
    Device device("subdiv_accel=cbvh,cbvh_memory=" + std::string(value));
    EXPECT_TRUE(device) << value;
    const std::string items = std::string("1,memory=") + value;
    const Environment set(items.c_str());
    Device other;
    EXPECT_TRUE(other) << value;
  }
  for (const char* value : {"0", "-1", "M", "12X", "12MB", "1e300", "nan", "0x10"}) {
    testing::internal::CaptureStderr();
    Device device("subdiv_accel=cbvh,cbvh_memory=" + std::string(value));
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_FALSE(device) << value;
    EXPECT_NE(text.find("cbvh_memory: expected bytes"), std::string::npos) << text;
  }
}

}} // namespace programs::test
