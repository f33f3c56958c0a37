// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cbvh_terrain: known sky-view factors, tiles that form one surface, and invalid arguments. */

#include "basics/image_file.h"
#include "support/message_parts.h"

#include <gtest/gtest.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace cbvh {
namespace {

struct Picture
{
  int width = 0, height = 0;
  std::vector<float> values;

  float at(int x, int y) const { return values.at(size_t(y) * size_t(width) + size_t(x)); }
};

class Terrain : public testing::Test
{
protected:
  Terrain()
  {
    char name[] = "/tmp/cbvh-terrain-XXXXXX";
    folder = mkdtemp(name);
  }
  ~Terrain() { std::filesystem::remove_all(folder); }

  template<typename T>
  std::string write(OIIO::TypeDesc type, int width, int height, const std::function<double(int x, int y)>& heightAt)
  {
    std::vector<T> samples;
    for (int y = 0; y < height; y++)
      for (int x = 0; x < width; x++)
        samples.push_back(T(heightAt(x, y)));
    const std::string path = folder + "/raster" + std::to_string(files++) + ".tif";
    writeImageFile(path, OIIO::ImageSpec(width, height, 1, type), type, samples.data());
    return path;
  }

  /* Runs the program and returns its output as floats. */
  Picture run(const std::string& arguments, const std::string& extension = ".tif")
  {
    const std::string path = folder + "/factors" + std::to_string(files++) + extension;
    const std::string command = std::string(PROGRAM) + " " + arguments + " --output " + path;
    Picture picture;
    EXPECT_EQ(std::system((command + " >" + folder + "/stdout 2>" + folder + "/stderr").c_str()), 0) << command
        << "\n" << textOf("/stderr");
    if (const auto input = OIIO::ImageInput::open(path))
    {
      isFloat = input->spec().format == OIIO::TypeDesc::FLOAT;
      picture.width = input->spec().width;
      picture.height = input->spec().height;
      picture.values.resize(size_t(picture.width) * size_t(picture.height));
      EXPECT_TRUE(input->read_image(0, 0, 0, 1, OIIO::TypeDesc::FLOAT, picture.values.data()));
    }
    return picture;
  }

  std::string textOf(const std::string& name)
  {
    std::ifstream file(folder + name);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  void expectRefusal(const std::string& arguments, const std::vector<std::string>& parts)
  {
    const int status = std::system((std::string(PROGRAM) + " " + arguments + " --output " + folder
        + "/none.tif >/dev/null 2>" + folder + "/stderr").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << arguments;
    EXPECT_TRUE(test::containsInOrder(textOf("/stderr"), parts));
  }

  std::string folder;
  int files = 0;
  bool isFloat = false;
};

double hills(int x, int y)
{
  const double large = 40 * std::sin(0.11 * x + 0.03 * y) * std::cos(0.07 * y);
  return large + 9 * std::sin(0.7 * x) * std::sin(0.5 * y + 0.2 * x);
}

TEST_F(Terrain, SamplesOfPgmAreHeightsWhateverTheMaximum)
{
  const auto heightAt = [](int x, int y) { return 2000 + std::lround(20 * hills(x, y)); };
  const Picture expected = run(write<uint16_t>(OIIO::TypeDesc::UINT16, 60, 50, heightAt));
  for (int most : {4095, 60000, 65535})
  {
    const std::string path = folder + "/raster.pgm";
    std::ofstream file(path, std::ios::binary);
    file << "P5\n60 50\n" << most << "\n";
    for (int i = 0; i < 60 * 50; i++)
      file << char(heightAt(i % 60, i / 60) >> 8) << char(heightAt(i % 60, i / 60));
    file.close();
    EXPECT_EQ(run(path).values, expected.values) << most;
  }
}

TEST_F(Terrain, FlatTerrainSeesTheWholeSky)
{
  for (double height : {0.0, -3.0, 1234.5})
  {
    const Picture picture = run(write<float>(OIIO::TypeDesc::FLOAT, 201, 201, [=](int, int) { return height; })
        + " --tile 64");
    EXPECT_TRUE(isFloat);
    ASSERT_EQ(picture.values.size(), 201u * 201u);
    for (float factor : picture.values)
      ASSERT_EQ(factor, 1.0f);
  }
}

/* A round pit of radius R and depth D with a level floor. From its center all horizons are at atan(D/R), so the factor
 * is R^2/(R^2 + D^2). The wall is one cell wide. */
TEST_F(Terrain, PitSeesTheSkyAboveItsRim)
{
  const int radius = 80, middle = 100;
  for (int depth : {20, 160})
  {
    const int cell = depth == 20 ? 1 : 5;
    const double expected = 1.0 * radius * radius / (radius * radius + depth * depth);
    const auto heightAt = [=](int x, int y) {
      return std::hypot(x - middle, y - middle) < radius ? 1000 : 1000 + depth * cell;
    };
    const std::string options = " --azimuths 32 --tile 33 --crop 100,100,101,101 --cell " + std::to_string(cell);
    const Picture ofUnsigned = run(write<uint16_t>(OIIO::TypeDesc::UINT16, 201, 201, heightAt) + options);
    const std::string path = write<int16_t>(OIIO::TypeDesc::INT16, 201, 201,
        [=](int x, int y) { return heightAt(x, y) - 2000; });
    const Picture ofSigned = run(path + options), in16Bits = run(path + options, ".png");
    ASSERT_EQ(ofUnsigned.values.size(), 1u);
    EXPECT_NEAR(ofUnsigned.at(0, 0), expected, 0.01) << "depth " << depth;
    EXPECT_NEAR(ofSigned.at(0, 0), expected, 0.01) << "depth " << depth;
    EXPECT_NEAR(in16Bits.at(0, 0), ofSigned.at(0, 0), 1.0 / 65535);
  }
}

/* No ray passes between two tiles, and all hits match those of an undivided terrain. */
TEST_F(Terrain, TilesFormOneSurface)
{
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 121, 101, hills) + " --cell 2 --azimuths 8";
  const Picture whole = run(path), tiles = run(path + " --tile 17"), kernel = run(path + " --embree triangle");
  ASSERT_EQ(whole.values.size(), 121u * 101u);
  EXPECT_EQ(whole.values, tiles.values);
  double mean = 0, difference = 0;
  for (size_t i = 0; i < whole.values.size(); i++)
  {
    mean += whole.values[i] / double(whole.values.size());
    difference += std::abs(whole.values[i] - kernel.values.at(i)) / double(whole.values.size());
  }
  EXPECT_LT(mean, 0.8) << "the hills hide some of the sky";
  EXPECT_LT(difference, 0.005);
}

/* The quads are flat, because their diagonals are not mirrored. */
TEST_F(Terrain, CopiesAreMirrored)
{
  const auto heightAt = [](int x, int y) {
    return 20 * std::sin(0.21 * x) + 5 * std::sin(0.9 * x) + 11 * std::cos(0.4 * y);
  };
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 41, 31, heightAt)
      + " --cell 3 --azimuths 8 --max-error 0.001 --height-repeat 2x3";
  const Picture plain = run(path + " --noise-height 0"), noisy = run(path);
  ASSERT_EQ(plain.width, 81);
  ASSERT_EQ(plain.height, 91);
  size_t same = 0;
  for (int y = 0; y < 91; y++)
    for (int x = 0; x < 81; x++)
    {
      EXPECT_NEAR(plain.at(x, y), plain.at(80 - x, y), 0.004);
      same += noisy.at(x, y) == noisy.at(80 - x, y);
    }
  EXPECT_LT(same, plain.values.size() / 4);
}

TEST_F(Terrain, MissingSamplesAreHoles)
{
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 51, 51,
      [](int x, int y) { return x == 20 && y > 10 ? -9999.0 : y == 3 ? NAN : hills(x, y); });
  const Picture picture = run(path + " --nodata -9999 --azimuths 4 --tile 20");
  ASSERT_EQ(picture.values.size(), 51u * 51u);
  for (int y = 0; y < 51; y++)
    for (int x = 0; x < 51; x++)
      ASSERT_EQ(std::isnan(picture.at(x, y)), (x == 20 && y > 10) || y == 3) << x << ", " << y;
}

TEST_F(Terrain, LosslessVerticesDoNotMove)
{
  run(write<float>(OIIO::TypeDesc::FLOAT, 41, 31, hills) + " --azimuths 4 --max-error 0");
  EXPECT_NE(textOf("/stdout").find("moved: 0\n"), std::string::npos) << textOf("/stdout");
}

/* Before horizons are computed, which may take hours. */
TEST_F(Terrain, UnusableOutputsAreRejectedAtOnce)
{
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 21, 21, hills);
  const std::string missing = folder + "/missing", xyz = folder + "/a.xyz";
  const std::pair<std::string, std::vector<std::string>> outputs[] = {
    {missing + "/a.tif", {missing + "/a.tif", missing}},
    {xyz, {xyz}},
    {folder + "/a.fits", {folder + "/a.fits", "fits", "tif"}}, // OpenImageIO's writers have errors
    {folder + "/a.rla", {folder + "/a.rla", "rla", "tif"}},
    {folder, {folder, std::strerror(EISDIR)}},
    {path, {path, "input"}},
    {"''", {"--output ''"}}};
  for (const auto& [output, parts] : outputs)
  {
    const std::string command = std::string(PROGRAM) + " " + path + " --output " + output;
    const int status = std::system((command + " >" + folder + "/stdout 2>" + folder + "/stderr").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << command;
    EXPECT_TRUE(test::containsInOrder(textOf("/stderr"), parts));
    EXPECT_EQ(textOf("/stdout"), "");
  }
}

TEST_F(Terrain, AnyNameOfPngSelects16Bits)
{
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 21, 21, hills) + " --azimuths 4";
  const Picture expected = run(path, ".png");
  for (const char* extension : {".PNG", ""})
    EXPECT_EQ(run(path, extension).values, expected.values) << extension;
}

TEST_F(Terrain, InvalidArgumentsAreRejected)
{
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 21, 21, hills);
  expectRefusal(path + " --crop 0,0,22,21", {"--crop 0,0,22,21", "0,0,21,21"});
  expectRefusal(path + " --cell 0", {"--cell 0"});
  expectRefusal(path + " --accuracy nan", {"--accuracy nan", "0.001", "10"});
  const std::string none = write<float>(OIIO::TypeDesc::FLOAT, 21, 21, [](int, int) { return NAN; }),
                    huge = write<float>(OIIO::TypeDesc::FLOAT, 21, 21, [](int x, int) { return x % 2 ? 3e38 : -3e38; });
  expectRefusal(none, {none, "no quad"});
  expectRefusal(huge, {huge, "no quad"});
  expectRefusal(path + " --height-repeat 0", {"--height-repeat '0'", " 3x2"});
  expectRefusal(path + " --height-repeat 1.5", {"--height-repeat '1.5'", " 1 ", "1000000"});
  expectRefusal(path + " --height-repeat 1x100000", {"--height-repeat 1x100000", " 1000000 "});
  expectRefusal(path + " --embree nothing", {"--embree"});
  expectRefusal(folder + "/missing.tif", {folder + "/missing.tif"});
  const std::string narrow = write<float>(OIIO::TypeDesc::FLOAT, 1, 21, hills);
  expectRefusal(narrow, {narrow, "1 x 21"});
  ASSERT_EQ(mkfifo((folder + "/pipe.tif").c_str(), 0600), 0);
  expectRefusal(folder + "/pipe.tif", {folder + "/pipe.tif: ", "pipe"});
}

} // namespace
} // namespace cbvh
