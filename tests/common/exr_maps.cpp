// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Maps in OpenEXR files that OpenImageIO's writer does not produce: channels, parts and levels. */

#include "support/map_files.h"
#include "support/message_parts.h"
#include "surface/height_map.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

namespace programs::test { namespace {

namespace fs = std::filesystem;

using ExrMaps = MapFiles;
using Channels = std::map<std::string, float>; // constant values

Imf::Header headerOf(const Channels& channels, int size) {
  Imf::Header header(size, size);
  for (const auto& [name, value] : channels) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  return header;
}

/* All rows are the same. */
Imf::FrameBuffer rowsOf(const Channels& channels, int size, std::vector<float>& storage) {
  Imf::FrameBuffer frame;
  storage.clear();
  for (const auto& [name, value] : channels) storage.insert(storage.end(), size_t(size), value);
  float* row = storage.data();
  for (const auto& [name, value] : channels) {
    frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(row), sizeof(float), 0));
    row += size;
  }
  return frame;
}

std::string writeExr(const std::string& path, const Channels& channels) {
  std::vector<float> storage;
  Imf::OutputFile file(path.c_str(), headerOf(channels, 8));
  file.setFrameBuffer(rowsOf(channels, 8, storage));
  file.writePixels(8);
  return path;
}

TEST_F(ExrMaps, ExrChannelsOfHeightsAreFound) {
  const std::string path = pathOf("map.exr");
  writeExr(path, {{"Alpha", 1.0f}, {"Height", 0.3f}});
  EXPECT_EQ(valueAt(path), 0.3f);
  EXPECT_EQ(HeightMap::read(path).at(3, 3), 0.3f);
  EXPECT_EQ(valueAt(path, "Alpha"), 1.0f);
  EXPECT_EQ(valueAt(path, "0"), 1.0f) << "numbers count all channels";
  writeExr(path, {{"A", 1.0f}, {"bump", 0.3f}});
  EXPECT_EQ(valueAt(path), 0.3f);
  writeExr(path, {{"layer.A", 1.0f}, {"layer.bump", 0.3f}});
  EXPECT_EQ(valueAt(path), 0.3f);
  writeExr(path, {{"R", 0.1f}, {"G", 0.2f}, {"B", 0.25f}, {"height", 0.3f}});
  EXPECT_EQ(valueAt(path), 0.3f) << "a channel of this name is the map";
  EXPECT_EQ(valueAt(path, "", 3), 0.1f) << "vectors have three channels";
  writeExr(path, {{"A", 1.0f}, {"X", 0.1f}, {"Y", 0.2f}, {"Z", 0.3f}});
  EXPECT_EQ(valueAt(path, "", 3), 0.1f);
  writeExr(path, {{"A", 0.4f}});
  EXPECT_EQ(valueAt(path), 0.4f) << "there is no other channel";
}

TEST_F(ExrMaps, PartsOfExrAreFoundByTheirChannels) {
  const std::string path = pathOf("parts.exr");
  const std::pair<const char*, Channels> parts[] = {{"beauty", {{"A", 1.0f}, {"R", 0.1f}, {"G", 0.2f}, {"B", 0.3f}}},
                                                    {"sculpt", {{"Alpha", 1.0f}, {"bump", 0.4f}}},
                                                    {"other", {{"bump", 0.5f}}}};
  std::vector<Imf::Header> headers;
  for (const auto& [name, channels] : parts) {
    headers.push_back(headerOf(channels, 8));
    headers.back().setName(name);
    headers.back().setType(Imf::SCANLINEIMAGE);
  }
  {
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), int(headers.size()));
    for (int i = 0; i < 3; i++) {
      std::vector<float> storage;
      Imf::OutputPart part(file, i);
      part.setFrameBuffer(rowsOf(parts[i].second, 8, storage));
      part.writePixels(8);
    }
  }
  for (unsigned image = 0; image < 3; image++)
    EXPECT_EQ(valueAt(path, "", 1, image), image == 0 ? 0.1f : image == 1 ? 0.4f : 0.5f);
  EXPECT_EQ(valueAt(path, "G"), 0.2f);
  EXPECT_EQ(valueAt(path, "bump"), 0.4f);
  EXPECT_EQ(valueAt(path, "other.bump"), 0.5f);
  EXPECT_TRUE(containsInOrder(errorOf(path, "dents"), {path, "dents", "R, G, B", "beauty", "bump", "sculpt", "other"}));
  EXPECT_TRUE(containsInOrder(errorOf(path, "bump", 3), {path, " 3 ", "bump"}));
}

/* A tiled image of s + 2t, whose size is a multiple of its tiles. */
std::string writeLevels(const std::string& path, Imf::LevelMode mode) {
  constexpr int size = 128, tile = 16;
  Imf::Header header = headerOf({{"Y", 0.0f}}, size);
  header.compression() = Imf::NO_COMPRESSION;
  header.setTileDescription(Imf::TileDescription(tile, tile, mode));
  Imf::TiledOutputFile file(path.c_str(), header);
  for (int ly = 0; ly < file.numYLevels(); ly++)
    for (int lx = 0; lx < file.numXLevels(); lx++) {
      if (!file.isValidLevel(lx, ly)) continue;
      const int w = file.levelWidth(lx), h = file.levelHeight(ly);
      std::vector<float> texels;
      for (int i = 0; i < w * h; i++)
        texels.push_back((float(i % w) + 0.5f) / float(w) + 2.0f * (float(i / w) + 0.5f) / float(h));
      Imf::FrameBuffer frame;
      frame.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(texels.data()), sizeof(float),
                                   sizeof(float) * size_t(w)));
      file.setFrameBuffer(frame);
      file.writeTiles(0, file.numXTiles(lx) - 1, 0, file.numYTiles(ly) - 1, lx, ly);
    }
  return path;
}

TEST_F(ExrMaps, MipMapsAndRipMapsOfExrAreRead) {
  for (Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS, Imf::RIPMAP_LEVELS}) {
    const std::string path = writeLevels(pathOf("levels.exr"), mode);
    std::string warnings;
    const HeightTexture texture({path}, {"", 1, 0.5f}, TextureWrap::Clamp, warnings);
    for (float texels : {0.0f, 1.0f, 4.0f})
      for (float t : {0.3f, 0.5f, 0.6f})
        for (float s : {0.35f, 0.5f, 0.7f}) {
          float sampled = NAN;
          texture.sample(0, s, t, texels / 128, texels / 128, &sampled);
          EXPECT_NEAR(sampled, s + 2.0f * t, 1e-4f) << mode << " at " << s << "," << t << ", width " << texels;
        }
  }
}

TEST_F(ExrMaps, LevelsThatCannotBeReadAreAnError) {
  const std::string path = writeLevels(pathOf("levels.exr"), Imf::MIPMAP_LEVELS);
  fs::resize_file(path, fs::file_size(path) - 1000); // in the last levels
  EXPECT_TRUE(containsInOrder(errorOf(path), {path, "image 0"}));
  /* In the header of a tile, its column and row, twice its level, and its bytes. */
  writeLevels(path, Imf::MIPMAP_LEVELS);
  std::ifstream stream(path, std::ios::binary);
  std::string file(std::istreambuf_iterator<char>(stream), {});
  const uint32_t header[5] = {2, 2, 1, 1, 16 * 16 * sizeof(float)};
  const size_t at = file.find(std::string(reinterpret_cast<const char*>(header), sizeof header));
  ASSERT_NE(at, std::string::npos);
  file[at] = 99;
  EXPECT_TRUE(containsInOrder(errorOf(save("levels.exr", file)), {path, "image 0"}));
}

TEST_F(ExrMaps, HeightsAreWrittenIntoAChannelThatDwaKeeps) {
  const std::string path = pathOf("written.exr");
  HeightMap map(64, 64);
  for (int i = 0; i < 64 * 64; i++) map.at(i % 64, i / 64) = std::sin(float(i * i));
  map.write(path);
  const auto input = OIIO::ImageInput::open(path);
  ASSERT_TRUE(input);
  OIIO::ImageSpec spec = input->spec();
  EXPECT_EQ(spec.channelnames, std::vector<std::string>{"height"});
  spec.attribute("compression", "dwaa");
  std::vector<float> texels(64 * 64);
  ASSERT_TRUE(input->read_image(0, 0, 0, 1, OIIO::TypeDesc::FLOAT, texels.data()));
  const auto output = OIIO::ImageOutput::create(path);
  const std::string packed = pathOf("packed.exr");
  ASSERT_TRUE(output->open(packed, spec) && output->write_image(OIIO::TypeDesc::FLOAT, texels.data()) &&
              output->close());
  const HeightMap again = HeightMap::read(packed);
  for (int i = 0; i < 64 * 64; i++) EXPECT_EQ(again.at(i % 64, i / 64), map.at(i % 64, i / 64));
}

}} // namespace programs::test
