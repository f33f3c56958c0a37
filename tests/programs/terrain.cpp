// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cbvh_terrain: known sky-view factors, tiles that form one surface, and invalid arguments. */

#include "basics/image_file.h"
#include "surface/geo_tiff.h"
#include "support/message_parts.h"
#include "support/tiff_file.h"

#include <gtest/gtest.h>

#include <algorithm>
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

namespace programs { namespace {

struct Picture {
  int width = 0, height = 0;
  std::vector<float> values;

  float at(int x, int y) const { return values.at(size_t(y) * size_t(width) + size_t(x)); }
};

class Terrain : public testing::Test {
protected:
  Terrain() {
    char name[] = "/tmp/cbvh-terrain-XXXXXX";
    folder = mkdtemp(name);
  }
  ~Terrain() { std::filesystem::remove_all(folder); }

  template<typename T>
  std::string write(OIIO::TypeDesc type, int width, int height, const std::function<double(int x, int y)>& heightAt) {
    std::vector<T> samples;
    for (int y = 0; y < height; y++)
      for (int x = 0; x < width; x++) samples.push_back(T(heightAt(x, y)));
    const std::string path = folder + "/raster" + std::to_string(files++) + ".tif";
    writeImageFile(path, OIIO::ImageSpec(width, height, 1, type), type, samples.data());
    return path;
  }

  /* Runs the program and returns its output as floats. */
  Picture run(const std::string& arguments, const std::string& extension = ".tif") {
    const std::string path = folder + "/factors" + std::to_string(files++) + extension;
    const std::string command = std::string(PROGRAM) + " " + arguments + " --output " + path;
    Picture picture;
    EXPECT_EQ(std::system((command + " >" + folder + "/stdout 2>" + folder + "/stderr").c_str()), 0)
        << command << "\n"
        << textOf("/stderr");
    if (const auto input = OIIO::ImageInput::open(path)) {
      isFloat = input->spec().format == OIIO::TypeDesc::FLOAT;
      picture.width = input->spec().width;
      picture.height = input->spec().height;
      picture.values.resize(size_t(picture.width) * size_t(picture.height));
      EXPECT_TRUE(input->read_image(0, 0, 0, 1, OIIO::TypeDesc::FLOAT, picture.values.data()));
    }
    return picture;
  }

  std::string textOf(const std::string& name) {
    std::ifstream file(folder + name);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  void expectRefusal(const std::string& arguments, const std::vector<std::string>& parts) {
    const int status = std::system((std::string(PROGRAM) + " " + arguments + " --output " + folder +
                                    "/none.tif >/dev/null 2>" + folder + "/stderr")
                                       .c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << arguments;
    EXPECT_TRUE(test::containsInOrder(textOf("/stderr"), parts));
  }

  std::string folder;
  int files = 0;
  bool isFloat = false;
};

double hills(int x, int y) {
  const double large = 40 * std::sin(0.11 * x + 0.03 * y) * std::cos(0.07 * y);
  return large + 9 * std::sin(0.7 * x) * std::sin(0.5 * y + 0.2 * x);
}

TEST_F(Terrain, SamplesOfPgmAreHeightsWhateverTheMaximum) {
  const auto heightAt = [](int x, int y) { return 2000 + std::lround(20 * hills(x, y)); };
  const Picture expected = run(write<uint16_t>(OIIO::TypeDesc::UINT16, 60, 50, heightAt));
  for (int most : {4095, 60000, 65535}) {
    const std::string path = folder + "/raster.pgm";
    std::ofstream file(path, std::ios::binary);
    file << "P5\n60 50\n" << most << "\n";
    for (int i = 0; i < 60 * 50; i++) file << char(heightAt(i % 60, i / 60) >> 8) << char(heightAt(i % 60, i / 60));
    file.close();
    EXPECT_EQ(run(path).values, expected.values) << most;
  }
}

/* Packs samples as TIFF does, in whole bytes per row. */
std::string packed(int width, int height, unsigned bits, const std::function<unsigned(int x, int y)>& sampleAt) {
  std::string bytes;
  for (int y = 0; y < height; y++) {
    unsigned buffer = 0, count = 0;
    for (int x = 0; x < width; x++) {
      buffer = buffer << bits | sampleAt(x, y);
      for (count += bits; count >= 8; count -= 8) bytes += char(buffer >> (count - 8));
      buffer &= (1u << count) - 1;
    }
    if (count) bytes += char(buffer << (8 - count));
  }
  return bytes;
}

TEST_F(Terrain, IntegersOfAnyNumberOfBitsAreHeights) {
  const auto heightAt = [](int x, int y) { return unsigned(x * 7 + y * 5 + x * y) % 16; };
  const std::string options = " --cell 2 --azimuths 4";
  const Picture expected = run(write<uint16_t>(OIIO::TypeDesc::UINT16, 13, 11, heightAt) + options);
  for (const unsigned bits : {4, 6, 8, 10, 12, 14}) {
    test::TiffLayout layout;
    layout.width = 13;
    layout.height = 11;
    layout.bits = bits;
    const std::string path = folder + "/packed" + std::to_string(bits) + ".tif";
    test::writeTiff(path, layout, packed(13, 11, bits, heightAt));
    EXPECT_EQ(run(path + options).values, expected.values) << bits;
  }
  test::TiffLayout layout;
  layout.width = layout.height = 4;
  layout.bits = 24;
  test::writeTiff(folder + "/24.tif", layout, std::string(48, 1));
  expectRefusal(folder + "/24.tif", {"24.tif", "24 bits", "reverse", "16 or 32"});
}

TEST_F(Terrain, FlatTerrainSeesTheWholeSky) {
  for (double height : {0.0, -3.0, 1234.5}) {
    const Picture picture =
        run(write<float>(OIIO::TypeDesc::FLOAT, 201, 201, [=](int, int) { return height; }) + " --tile 64");
    EXPECT_TRUE(isFloat);
    ASSERT_EQ(picture.values.size(), 201u * 201u);
    for (float factor : picture.values) ASSERT_EQ(factor, 1.0f);
  }
}

/* A round pit of radius R and depth D with a level floor. From its center all horizons are at atan(D/R), so the factor
 * is R^2/(R^2 + D^2). The wall is one cell wide. */
TEST_F(Terrain, PitSeesTheSkyAboveItsRim) {
  const int radius = 80, middle = 100;
  for (int depth : {20, 160}) {
    const int cell = depth == 20 ? 1 : 5;
    const double expected = 1.0 * radius * radius / (radius * radius + depth * depth);
    const auto heightAt = [=](int x, int y) {
      return std::hypot(x - middle, y - middle) < radius ? 1000 : 1000 + depth * cell;
    };
    const std::string options = " --azimuths 32 --tile 33 --crop 100,100,101,101 --cell " + std::to_string(cell);
    const Picture ofUnsigned = run(write<uint16_t>(OIIO::TypeDesc::UINT16, 201, 201, heightAt) + options);
    const std::string path =
        write<int16_t>(OIIO::TypeDesc::INT16, 201, 201, [=](int x, int y) { return heightAt(x, y) - 2000; });
    const Picture ofSigned = run(path + options), in16Bits = run(path + options, ".png");
    ASSERT_EQ(ofUnsigned.values.size(), 1u);
    EXPECT_NEAR(ofUnsigned.at(0, 0), expected, 0.01) << "depth " << depth;
    EXPECT_NEAR(ofSigned.at(0, 0), expected, 0.01) << "depth " << depth;
    EXPECT_NEAR(in16Bits.at(0, 0), ofSigned.at(0, 0), 1.0 / 65535);
  }
}

/* No ray passes between two tiles, and all hits match those of an undivided terrain. */
TEST_F(Terrain, TilesFormOneSurface) {
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 121, 101, hills) + " --cell 2 --azimuths 8";
  const Picture whole = run(path), tiles = run(path + " --tile 17"), kernel = run(path + " --embree triangle");
  ASSERT_EQ(whole.values.size(), 121u * 101u);
  EXPECT_EQ(whole.values, tiles.values);
  double mean = 0, difference = 0;
  for (size_t i = 0; i < whole.values.size(); i++) {
    mean += whole.values[i] / double(whole.values.size());
    difference += std::abs(whole.values[i] - kernel.values.at(i)) / double(whole.values.size());
  }
  EXPECT_LT(mean, 0.8) << "the hills hide some of the sky";
  EXPECT_LT(difference, 0.005);
}

/* The quads are flat, because their diagonals are not mirrored. */
TEST_F(Terrain, CopiesAreMirrored) {
  const auto heightAt = [](int x, int y) {
    return 20 * std::sin(0.21 * x) + 5 * std::sin(0.9 * x) + 11 * std::cos(0.4 * y);
  };
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 41, 31, heightAt) +
                           " --cell 3 --azimuths 8 --max-error 0.001 --height-repeat 2x3";
  const Picture plain = run(path + " --noise-height 0"), noisy = run(path);
  ASSERT_EQ(plain.width, 81);
  ASSERT_EQ(plain.height, 91);
  size_t same = 0;
  for (int y = 0; y < 91; y++)
    for (int x = 0; x < 81; x++) {
      EXPECT_NEAR(plain.at(x, y), plain.at(80 - x, y), 0.004);
      same += noisy.at(x, y) == noisy.at(80 - x, y);
    }
  EXPECT_LT(same, plain.values.size() / 4);
}

TEST_F(Terrain, MissingSamplesAreHoles) {
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 51, 51, [](int x, int y) {
    return x == 20 && y > 10 ? -9999.0 : y == 3 ? NAN : hills(x, y);
  });
  const Picture picture = run(path + " --nodata -9999 --azimuths 4 --tile 20");
  ASSERT_EQ(picture.values.size(), 51u * 51u);
  for (int y = 0; y < 51; y++)
    for (int x = 0; x < 51; x++)
      ASSERT_EQ(std::isnan(picture.at(x, y)), (x == 20 && y > 10) || y == 3) << x << ", " << y;
}

/* 41 x 31 hills with missing samples, and the places and the coordinate system of a national grid. */
test::TiffLayout nationalLayout(bool isPoint) {
  test::TiffLayout t;
  t.width = 41;
  t.height = 31;
  t.bits = 32;
  t.format = 3;
  t.nodata = "-9999";
  t.pixelScale = {2, 2, 0};
  t.tiepoints = {3, 4, 0, 4512345.5, 5432109.25, 0};
  t.geoKeys = {1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, uint16_t(isPoint ? 2 : 1), 3072, 0, 1, 25832}; // projected
  return t;
}

std::string hillSamples() {
  std::vector<float> heights;
  for (int i = 0; i < 41 * 31; i++) heights.push_back(i == 9 * 41 + 7 ? -9999 : float(hills(i % 41, i / 41)));
  return test::bytesOf(heights);
}

void expectPlaces(const SamplePlaces& found, const SamplePlaces& expected) {
  const double a[] = {found.x0, found.xOfColumn, found.xOfRow, found.y0, found.yOfColumn, found.yOfRow};
  const double b[] = {expected.x0, expected.xOfColumn, expected.xOfRow,
                      expected.y0, expected.yOfColumn, expected.yOfRow};
  for (int i = 0; i < 6; i++) EXPECT_DOUBLE_EQ(a[i], b[i]) << i;
}

GeoTags tagsOf(const std::string& path) {
  const std::vector<TiffPage> pages = readTiffPages(path);
  EXPECT_EQ(pages.size(), 1u) << path;
  return pages.empty() ? GeoTags() : pages[0].tags;
}

TEST_F(Terrain, OutputsAreWhereTheInputIs) {
  const std::string path = folder + "/national.tif";
  for (const bool isPoint : {false, true})
    for (const bool isRotated : {false, true}) {
      SCOPED_TRACE(testing::Message() << isPoint << isRotated);
      test::TiffLayout t = nationalLayout(isPoint);
      t.isBigEndian = isPoint;
      t.isBigTiff = isPoint != isRotated;
      t.endsTexts = isPoint;
      t.metadata = "<GDALMetadata><Item name=\"STATISTICS_MAXIMUM\" sample=\"0\">49</Item></GDALMetadata>";
      SamplePlaces p = {4512345.5 - 6, 2, 0, 5432109.25 + 8, 0, -2};
      if (isRotated) {
        p = {4512345.5, 1.5, 0.75, 5432109.25, 0.5, -2};
        t.matrix = {p.xOfColumn, p.xOfRow, 0, p.x0, p.yOfColumn, p.yOfRow, 0, p.y0, 0, 0, 0, 0, 0, 0, 0, 1};
        t.pixelScale = t.tiepoints = {};
      }
      const double corner = isPoint ? 0 : 0.5; // of a pixel, from its center
      p.x0 += corner * (p.xOfColumn + p.xOfRow);
      p.y0 += corner * (p.yOfColumn + p.yOfRow);
      test::writeTiff(path, t, hillSamples());
      const Picture whole = run(path + " --cell 2 --azimuths 4");
      const GeoTags ofWhole = tagsOf(folder + "/factors" + std::to_string(files - 1) + ".tif");
      EXPECT_EQ(ofWhole.keys, t.geoKeys);
      EXPECT_EQ(ofWhole.nodata, "nan");
      EXPECT_EQ(ofWhole.metadata, "");
      ASSERT_TRUE(samplePlaces(ofWhole));
      expectPlaces(*samplePlaces(ofWhole), p);
      EXPECT_TRUE(std::isnan(whole.at(7, 9)));
      if (!isRotated) EXPECT_EQ(run(path + " --azimuths 4").at(3, 3), whole.at(3, 3)) << "the cell of the file";
      else EXPECT_NE(run(path + " --azimuths 4").at(3, 3), whole.at(3, 3)) << "oblong pixels: the default";
      const Picture part = run(path + " --cell 2 --azimuths 4 --crop 5,3,20,21", ".TIFF");
      const GeoTags ofPart = tagsOf(folder + "/factors" + std::to_string(files - 1) + ".TIFF");
      EXPECT_EQ(part.at(0, 0), whole.at(5, 3));
      EXPECT_EQ(ofPart.keys, t.geoKeys);
      p.x0 += 5 * p.xOfColumn + 3 * p.xOfRow;
      p.y0 += 5 * p.yOfColumn + 3 * p.yOfRow;
      ASSERT_TRUE(samplePlaces(ofPart));
      expectPlaces(*samplePlaces(ofPart), p);
    }
}

/* Control points of a part move with it. Copies have none, but continue a transformation. */
TEST_F(Terrain, ControlPointsAreKeptWithoutCopies) {
  const std::string path = folder + "/points.tif", options = " --cell 2 --azimuths 1";
  test::TiffLayout t = nationalLayout(false);
  const std::vector<double> points = {0, 0, 0, 10, 50, 0, 40, 0, 0, 11, 50, 0, 0, 30, 0, 10, 49, 0};
  t.pixelScale.clear();
  t.tiepoints = points;
  test::writeTiff(path, t, hillSamples());
  run(path + options + " --crop 5,3,20,21");
  std::vector<double> expected = points;
  for (size_t i = 0; i < points.size(); i += 6) expected[i] -= 5, expected[i + 1] -= 3;
  EXPECT_EQ(tagsOf(folder + "/factors0.tif").tiepoints, expected);
  run(path + options + " --height-repeat 2");
  EXPECT_EQ(tagsOf(folder + "/factors1.tif").tiepoints, std::vector<double>());
  EXPECT_EQ(tagsOf(folder + "/factors1.tif").keys, t.geoKeys);
  test::writeTiff(path, nationalLayout(false), hillSamples());
  run(path + options + " --height-repeat 2 --crop 50,40,60,50");
  const GeoTags tags = tagsOf(folder + "/factors2.tif");
  ASSERT_TRUE(samplePlaces(tags));
  expectPlaces(*samplePlaces(tags), {4512345.5 + 2 * (50 - 3 + 0.5), 2, 0, 5432109.25 - 2 * (40 - 4 + 0.5), 0, -2});
}

/* Value that GDAL reads at a place, or an empty text. */
std::string valueByGdal(const std::string& path, double x, double y) {
  char command[1000];
  std::snprintf(command, sizeof(command), "gdallocationinfo -valonly -geoloc %s %.17g %.17g 2>&1", path.c_str(), x, y);
  std::string text;
  FILE* const output = popen(command, "r");
  if (!output) return text;
  char line[200];
  while (std::fgets(line, sizeof(line), output)) text += line;
  pclose(output);
  return text;
}

TEST_F(Terrain, GdalFindsOutputsAtTheirPlace) {
  if (std::system("gdallocationinfo --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "requires Debian's gdal-bin";
  const std::string path = folder + "/national.tif";
  for (const bool isPoint : {false, true})
    for (const bool isRotated : {false, true}) {
      SCOPED_TRACE(testing::Message() << isPoint << isRotated);
      test::TiffLayout t = nationalLayout(isPoint);
      if (isRotated) {
        t.matrix = {1.5, 0.75, 0, 4512345.5, 0.5, -2, 0, 5432109.25, 0, 0, 0, 0, 0, 0, 0, 1};
        t.pixelScale = t.tiepoints = {};
      }
      test::writeTiff(path, t, hillSamples());
      const std::string options = path + " --cell 2 --azimuths 4";
      const Picture whole = run(options), part = run(options + " --crop 5,3,20,21");
      for (const auto& [x, y] : {std::pair(5, 3), std::pair(19, 20), std::pair(7, 9)}) {
        const SamplePlaces p = samplePlaces(tagsOf(path)).value();
        const double easting = p.x0 + x * p.xOfColumn + y * p.xOfRow, northing = p.y0 + x * p.yOfColumn + y * p.yOfRow;
        for (const int file : {2, 1}) {
          const std::string text =
              valueByGdal(folder + "/factors" + std::to_string(files - file) + ".tif", easting, northing);
          ASSERT_FALSE(text.empty());
          const float expected = file == 2 ? whole.at(x, y) : part.at(x - 5, y - 3);
          if (x == 7) EXPECT_TRUE(text.find("nan") != std::string::npos && std::isnan(expected)) << text;
          else EXPECT_NEAR(std::stod(text), double(expected), 1e-6) << text;
        }
        EXPECT_NEAR(std::stod(valueByGdal(path, easting, northing)), x == 7 ? -9999 : hills(x, y), 1e-4);
      }
    }
}

TEST_F(Terrain, ScaleAndOffsetOfGdalAreApplied) {
  test::TiffLayout t;
  t.width = 41;
  t.height = 31;
  t.bits = 16;
  t.format = 2;
  t.nodata = "-32768";
  std::vector<int16_t> samples;
  for (int i = 0; i < 41 * 31; i++)
    samples.push_back(i == 50 ? int16_t(-32768) : int16_t(std::lround(8 * hills(i % 41, i / 41))));
  const auto item = [](const char* role, const char* sample, const char* value) {
    return std::string("<Item name=\"X\" sample=\"") + sample + "\" role=\"" + role + "\">" + value + "</Item>";
  };
  const std::string path = folder + "/scaled.tif", options = " --cell 2 --azimuths 4";
  const auto expected = run(write<float>(OIIO::TypeDesc::FLOAT, 41, 31,
                                         [&](int x, int y) {
                                           const int16_t sample = samples[size_t(y * 41 + x)];
                                           return sample == -32768 ? NAN : 300 + 0.125 * sample;
                                         }) +
                            options);
  for (const bool isBig : {false, true}) {
    t.isBigEndian = t.isBigTiff = isBig;
    t.metadata = "<GDALMetadata>\n  " + item("scale", "1", "7") + item("offset", "0", "300") +
                 item("scale", "0", " 0.125") + "\n</GDALMetadata>\n";
    test::writeTiff(path, t, test::bytesOf(samples));
    const Picture found = run(path + options);
    for (size_t i = 0; i < expected.values.size(); i++)
      ASSERT_TRUE(found.values.at(i) == expected.values[i] || (i == 50 && std::isnan(found.values[i]))) << i;
  }
  t.metadata = "<GDALMetadata>" + item("scale", "0", "two") + "</GDALMetadata>";
  test::writeTiff(path, t, test::bytesOf(samples));
  expectRefusal(path, {path, "scale 'two'", "expected a finite number"});
}

/* Samples beside walls whose sky-view factor is farther than `tolerance` from the exact terrain's, and their number. */
std::array<size_t, 2> countBesideWalls(const Picture& ours, const Picture& exact, double tolerance,
                                       const std::function<double(int x, int y)>& heightAt) {
  std::array<size_t, 2> counts = {0, 0};
  for (int y = 0; y < exact.height; y++)
    for (int x = 0; x < exact.width; x++) {
      bool isBesideWall = false;
      for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
          const int i = std::clamp(x + dx, 0, exact.width - 1), j = std::clamp(y + dy, 0, exact.height - 1);
          isBesideWall |= heightAt(i, j) > heightAt(x, y) + 2;
        }
      counts[0] += isBesideWall && std::abs(ours.at(x, y) - exact.at(x, y)) > tolerance;
      counts[1] += isBesideWall;
    }
  return counts;
}

/* Columns and rows do not move, whatever the cell is: otherwise the stored wall leans over samples beside it. */
TEST_F(Terrain, SamplesBesideWallsSeeTheSky) {
  const auto tower = [](int x, int y) { return x >= 3 && x <= 5 && y >= 3 && y <= 5 ? 20.0 : 0.0; };
  const auto city = [](int x, int y) { return x % 17 < 8 && y % 13 < 7 ? 5.0 + (x / 17 * 7 + y / 13 * 3) % 20 : 0.0; };
  const std::string towerPath = write<float>(OIIO::TypeDesc::FLOAT, 8, 8, tower);
  const std::string cityPath = write<float>(OIIO::TypeDesc::FLOAT, 60, 60, city);
  for (const char* cell : {"0.2", "0.25", "0.3", "1.1", "0.0101", "3e5"}) {
    const std::string options = std::string(" --azimuths 8 --cell ") + cell;
    const Picture ofTower = run(towerPath + options), exactTower = run(towerPath + options + " --embree triangle"),
                  ofCity = run(cityPath + options), exactCity = run(cityPath + options + " --embree triangle");
    const std::array<size_t, 2> tower8 = countBesideWalls(ofTower, exactTower, 0.02, tower),
                                city60 = countBesideWalls(ofCity, exactCity, 0.02, city);
    EXPECT_EQ(tower8[0], 0u) << "of " << tower8[1] << " at the tower, --cell " << cell;
    EXPECT_EQ(city60[0], 0u) << "of " << city60[1] << " in the city, --cell " << cell;
    EXPECT_GT(city60[1], 300u);
  }
}

/* On a plane with a small slope, each sample sees nearly the whole sky, although the stored plane has steps. */
TEST_F(Terrain, RaysStartAboveTheStoredSurfaceAtAnyError) {
  const std::string path =
      write<float>(OIIO::TypeDesc::FLOAT, 101, 101, [](int x, int y) { return 300 + 0.003 * x + 0.007 * y; });
  for (const char* error : {"0.001", "0.02", "0.1", "0.5"}) {
    const Picture picture = run(path + " --azimuths 8 --cell 1 --max-error " + error);
    ASSERT_EQ(picture.values.size(), 101u * 101u);
    for (float factor : picture.values) ASSERT_GT(factor, 0.5f) << "--max-error " << error;
  }
}

TEST_F(Terrain, RaysStartAboveSurfacesWhoseFloatsAreCoarse) {
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 21, 21, [](int, int) { return 3e6; });
  for (float factor : run(path + " --cell 0.2 --azimuths 8").values) ASSERT_EQ(factor, 1.0f);
  EXPECT_TRUE(test::containsInOrder(textOf("/stderr"), {"warning", "--start-height 0.003125"})) << textOf("/stderr");
  run(write<float>(OIIO::TypeDesc::FLOAT, 21, 21, hills) + " --azimuths 4");
  EXPECT_EQ(textOf("/stderr").find("warning"), std::string::npos) << textOf("/stderr");
}

TEST_F(Terrain, NoHeightMovesFartherThanHalfOfTheLargestError) {
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 41, 31, hills) + " --azimuths 1 --cell 0.3";
  for (const double error : {1e-4, 0.03, 2.0}) {
    run(path + " --max-error " + std::to_string(error));
    const std::string text = textOf("/stdout"), mark = "moved: ";
    const double moved = std::stod(text.substr(text.find(mark) + mark.size()));
    EXPECT_GT(moved, error / 8);
    EXPECT_LE(moved, error / 2);
  }
}

/* 8-bit colors of map tiles; `channels` is 3 or 4. */
std::string writeColors(const std::string& path, int channels, const std::function<long(int x, int y)>& codeAt,
                        const std::function<int(int x, int y)>& alphaAt) {
  std::vector<uint8_t> bytes;
  for (int y = 0; y < 31; y++)
    for (int x = 0; x < 41; x++) {
      for (int shift : {16, 8, 0}) bytes.push_back(uint8_t(codeAt(x, y) >> shift));
      if (channels == 4) bytes.push_back(uint8_t(alphaAt(x, y)));
    }
  writeImageFile(path, OIIO::ImageSpec(41, 31, channels, OIIO::TypeDesc::UINT8), OIIO::TypeDesc::UINT8, bytes.data());
  return path;
}

TEST_F(Terrain, MapTilesAreDecoded) {
  const auto codeOfTerrarium = [](int x, int y) { return std::lround((hills(x, y) + 32768) * 256); };
  const auto codeOfMapbox = [](int x, int y) { return std::lround((hills(x, y) + 10000) * 10); };
  const auto isMissing = [](int x, int y) { return x == 7 && y == 9; };
  const auto alphaAt = [&](int x, int y) { return isMissing(x, y) ? 0 : 255; };
  const std::string options = " --azimuths 8 --cell 2";
  for (const bool isTerrarium : {true, false})
    for (const int channels : {3, 4}) {
      const std::function<long(int, int)> codeAt =
          isTerrarium ? std::function<long(int, int)>(codeOfTerrarium) : codeOfMapbox;
      const Picture expected = run(write<float>(OIIO::TypeDesc::FLOAT, 41, 31,
                                                [&](int x, int y) {
                                                  if (channels == 4 && isMissing(x, y)) return double(NAN);
                                                  return isTerrarium ? double(codeAt(x, y)) / 256 - 32768
                                                                     : double(codeAt(x, y)) / 10 - 10000;
                                                }) +
                                   options);
      const std::string file = folder + "/tile" + std::to_string(files++) + ".png";
      const std::string path = writeColors(file, channels, codeAt, alphaAt);
      const Picture decoded = run(path + options + " --encoding " + (isTerrarium ? "terrarium" : "mapbox"));
      ASSERT_EQ(decoded.values.size(), expected.values.size());
      for (size_t i = 0; i < expected.values.size(); i++)
        if (std::isnan(expected.values[i])) EXPECT_TRUE(std::isnan(decoded.values[i])) << i;
        else EXPECT_EQ(decoded.values[i], expected.values[i]) << i;
    }
}

TEST_F(Terrain, ColorsAreNoHeights) {
  const std::string path = writeColors(
      folder + "/relief.png", 3, [](int x, int y) { return (std::lround(hills(x, y) + 100) << 16) + 40 * y; }, nullptr);
  expectRefusal(path, {path, "3 channels (R, G, B)", "one channel", "--channel", "--encoding"});
  expectRefusal(path + " --channel height", {path, "--channel 'height'", "R, G, B"});
  expectRefusal(path + " --channel 3", {path, "--channel '3'", "R, G, B"});
  expectRefusal(path + " --encoding png", {"--encoding 'png'", "terrarium", "mapbox"});
  expectRefusal(path + " --encoding mapbox --channel R", {"--channel 'R'", "--encoding"});
  const std::string options = " --azimuths 4 --cell 2";
  const Picture red = run(path + options + " --channel R"), first = run(path + options + " --channel 0"),
                expected = run(write<uint8_t>(OIIO::TypeDesc::UINT8, 41, 31,
                                              [](int x, int y) { return std::lround(hills(x, y) + 100); }) +
                               options);
  EXPECT_EQ(red.values, expected.values);
  EXPECT_EQ(first.values, expected.values);
  test::TiffLayout palette;
  palette.width = palette.height = 4;
  palette.photometric = 3;
  palette.colors = std::vector<uint16_t>(3 * 256, 40000);
  const std::string indexed = folder + "/palette.tif";
  test::writeTiff(indexed, palette, std::string(16, 7));
  expectRefusal(indexed, {indexed, "3 channels", "one channel"});
  const std::string grey = write<float>(OIIO::TypeDesc::FLOAT, 21, 21, hills);
  expectRefusal(grey + " --encoding terrarium", {grey, "1 channel", "float", "uint8", "--encoding"});
}

/* The first page may be a mask. */
TEST_F(Terrain, SmallerCopiesAndMasksAreNotTheTerrain) {
  constexpr unsigned smaller = 1, mask = 4; // NewSubfileType
  const std::string path = folder + "/pages.tif", alone = write<float>(OIIO::TypeDesc::FLOAT, 41, 31, hills);
  const auto writePages = [&](const std::vector<unsigned>& subfiles) {
    test::TiffWriter writer(false, false);
    for (const unsigned subfile : subfiles) {
      test::TiffLayout page;
      page.subfile = subfile;
      page.width = subfile == smaller ? 20 : 41;
      page.height = subfile == smaller ? 15 : 31;
      page.bits = subfile == mask ? 8 : 32;
      page.format = subfile == mask ? 1 : 3;
      std::vector<float> heights;
      for (int y = 0; y < int(page.height); y++)
        for (int x = 0; x < int(page.width); x++) heights.push_back(subfile ? 1.0f : float(hills(x, y)));
      writer.addPage(page, subfile == mask ? std::string(41 * 31, '\xff') : test::bytesOf(heights));
    }
    writer.save(path);
  };
  writePages({mask, smaller, 0});
  const std::string options = " --azimuths 4 --cell 2";
  EXPECT_EQ(run(path + options).values, run(alone + options).values);
  writePages({mask, smaller});
  expectRefusal(path, {path, "only smaller copies or masks"});
}

TEST_F(Terrain, LosslessVerticesDoNotMove) {
  run(write<float>(OIIO::TypeDesc::FLOAT, 41, 31, hills) + " --azimuths 4 --max-error 0");
  EXPECT_NE(textOf("/stdout").find("moved: 0\n"), std::string::npos) << textOf("/stdout");
}

/* Before horizons are computed, which may take hours. */
TEST_F(Terrain, UnusableOutputsAreRejectedAtOnce) {
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
  for (const auto& [output, parts] : outputs) {
    const std::string command = std::string(PROGRAM) + " " + path + " --output " + output;
    const int status = std::system((command + " >" + folder + "/stdout 2>" + folder + "/stderr").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << command;
    EXPECT_TRUE(test::containsInOrder(textOf("/stderr"), parts));
    EXPECT_EQ(textOf("/stdout"), "");
  }
}

TEST_F(Terrain, AnyNameOfPngSelects16Bits) {
  const std::string path = write<float>(OIIO::TypeDesc::FLOAT, 21, 21, hills) + " --azimuths 4";
  const Picture expected = run(path, ".png");
  for (const char* extension : {".PNG", ""}) EXPECT_EQ(run(path, extension).values, expected.values) << extension;
}

TEST_F(Terrain, InvalidArgumentsAreRejected) {
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

}} // namespace programs
