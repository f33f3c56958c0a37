// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Maps in files, in a folder that is removed at the end. */

#include "basics/error.h"
#include "surface/height_texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

namespace programs::test {

class MapFiles : public testing::Test {
protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() / ("cbvh_map_files_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::string pathOf(const std::string& name) const { return (folder / name).string(); }

  std::string save(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return pathOf(name);
  }

  std::filesystem::path folder;
};

/* Returns the message with which the map is rejected, or empty. */
inline std::string errorOf(const std::string& path, const std::string& channel = "", int count = 1) {
  try {
    std::string warnings;
    const HeightTexture texture({path}, {channel, count, 0.5f}, TextureWrap::Clamp, warnings);
  } catch (const Error& e) { return e.what(); }
  return "";
}

/* Returns the first channel in the middle of an image. */
inline float valueAt(const std::string& path, const std::string& channel = "", int count = 1, unsigned image = 0) {
  std::string warnings;
  const HeightTexture texture({path}, {channel, count, 0.5f}, TextureWrap::Clamp, warnings);
  float values[3] = {NAN, NAN, NAN};
  texture.sample(image, 0.5f, 0.5f, 0.0f, 0.0f, values);
  return values[0];
}

} // namespace programs::test
