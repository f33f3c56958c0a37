// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/height_map.h"
#include "basics/error.h"
#include "support/message_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace programs::test { namespace {

namespace fs = std::filesystem;

/* 3 x 2 texels with distinct heights. */
HeightMap smallMap() {
  HeightMap map(3, 2);
  for (int y = 0; y < 2; y++)
    for (int x = 0; x < 3; x++) map.at(x, y) = float(x) + 10.0f * float(y);
  return map;
}

class HeightMapFile : public testing::Test {
protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("cbvh_height_map_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    path = (folder / "map.exr").string();
  }
  void TearDown() override { fs::remove_all(folder); }

  fs::path folder;
  std::string path;
};

TEST(HeightMap, IsBilinearBetweenTexelCenters) {
  const HeightMap map = smallMap();
  EXPECT_EQ(map.sampleTexels(1, 1), 11.0f);
  EXPECT_EQ(map.sampleTexels(0.25f, 0), 0.25f);
  EXPECT_EQ(map.sampleTexels(0.5f, 0.5f), 5.5f);
  EXPECT_EQ(map.sampleTexels(-5, 9), 10.0f) << "the border is repeated";
}

TEST_F(HeightMapFile, DetectsConstantBorders) {
  HeightMap map(3, 3);
  map.at(1, 1) = 7.0f;
  map.write(path);
  EXPECT_TRUE(HeightMap::inspect(path).constantBorder);
  map.at(2, 1) = 1.0f;
  map.write(path);
  EXPECT_FALSE(HeightMap::inspect(path).constantBorder);
}

TEST_F(HeightMapFile, FloatExrKeepsEveryBit) {
  HeightMap map = smallMap();
  map.at(1, 1) = 0.1f;
  map.at(2, 1) = -3.0e7f;
  map.write(path);
  const HeightMap again = HeightMap::read(path);
  ASSERT_EQ(again.width(), 3);
  ASSERT_EQ(again.height(), 2);
  for (int y = 0; y < 2; y++)
    for (int x = 0; x < 3; x++) EXPECT_EQ(again.at(x, y), map.at(x, y));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "a temporary file was left";
}

TEST_F(HeightMapFile, RejectsMissingTruncatedAndInvalidFiles) {
  EXPECT_THROW(HeightMap::read(path), Error);
  HeightMap(64, 64).write(path);
  fs::resize_file(path, fs::file_size(path) / 2);
  EXPECT_THROW(HeightMap::read(path), Error);
  fs::resize_file(path, 0);
  EXPECT_THROW(HeightMap::read(path), Error);
  std::ofstream(path) << "this is no image";
  EXPECT_THROW(HeightMap::read(path), Error);
  EXPECT_THROW(HeightMap::read(folder.string()), Error);
}

TEST_F(HeightMapFile, KeepsItsRecipe) {
  smallMap().write(path, "a pinch of noise");
  EXPECT_EQ(HeightMap::recipeOf(path), "a pinch of noise");
  EXPECT_EQ(HeightMap::inspect(path).images, 1u);
  smallMap().write(path);
  EXPECT_EQ(HeightMap::recipeOf(path), "");
  std::ofstream(path) << "this is no image";
  EXPECT_EQ(HeightMap::recipeOf(path), "");
  EXPECT_EQ(HeightMap::recipeOf(path + ".missing"), "");
}

TEST_F(HeightMapFile, RejectsPtexWithAReasonWithoutAReader) {
  const std::string ptex = (folder / "map.ptx").string();
  std::ofstream(ptex) << "Ptex";
  try {
    HeightMap::read(ptex);
    FAIL() << "expected an error";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).rfind(ptex, 0), 0u) << e.what();
  }
}

TEST_F(HeightMapFile, RejectsHeightsThatAreNotFinite) {
  HeightMap map = smallMap();
  map.at(2, 1) = NAN;
  map.write(path);
  try {
    HeightMap::read(path);
    FAIL() << "expected an error";
  } catch (const Error& e) { EXPECT_TRUE(containsInOrder(e.what(), {path, " 2,1 ", "finite"})); }
}

TEST_F(HeightMapFile, UnwritableFolderIsAnError) {
  EXPECT_THROW(smallMap().write((folder / "missing" / "map.exr").string()), Error);
}

}} // namespace programs::test
