// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Height maps in every pixel type and layout that OpenImageIO reads: the sampled height, or the error message. */

#include "basics/error.h"
#include "support/message_parts.h"
#include "support/tiff_file.h"
#include "surface/height_map.h"
#include "surface/height_texture.h"

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/half.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sys/stat.h>
#include <unistd.h>

namespace programs::test { namespace {

namespace fs = std::filesystem;

constexpr unsigned size = 20; // width and height of images; tiles of 16 are clipped

class MapFormats : public testing::Test {
protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("cbvh_map_formats_" + std::to_string(::getpid()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  std::string pathOf(const std::string& name) const { return (folder / name).string(); }

  fs::path folder;
};

struct Sample {
  float height = NAN, mean = NAN; // filtered over at most one texel, and over two texels
  std::string error, warnings;
};

Sample sampleAt(const std::string& path, float s, float t, TextureWrap wrap = TextureWrap::Clamp, float neutral = 0.5f,
                const std::string& channel = "") {
  Sample sample;
  try {
    const HeightTexture texture({path}, {channel, 1, neutral}, wrap, sample.warnings);
    texture.sample(0, s, t, 0.0f, 0.0f, &sample.height);
    // with a different filter
    texture.sample(0, s, t, 2.0f / texture.size(0).x, 2.0f / texture.size(0).y, &sample.mean);
  } catch (const Error& e) { sample.error = e.what(); }
  return sample;
}

/* One pixel, repeated over an image. */
std::string repeated(const std::string& pixel) {
  std::string samples;
  for (unsigned i = 0; i < size * size; i++) samples += pixel;
  return samples;
}

template<typename T>
std::string pixelOf(std::vector<double> channels) {
  std::vector<T> samples;
  for (double x : channels) samples.push_back(T(float(x)));
  return bytesOf(samples);
}

template<typename T>
std::string integersOf(std::vector<double> channels) {
  std::vector<T> samples;
  for (double x : channels) samples.push_back(T(x));
  return bytesOf(samples);
}

struct PixelType {
  const char* name;
  unsigned bits, format;
  std::string (*pixel)(std::vector<double> channels); // channels from 0 to 1
  double greatest;                                    // the stored value of 1
};

const PixelType pixelTypes[] = {{"uint8", 8, 1, integersOf<uint8_t>, 255},
                                {"int8", 8, 2, integersOf<int8_t>, 127},
                                {"uint16", 16, 1, integersOf<uint16_t>, 65535},
                                {"int16", 16, 2, integersOf<int16_t>, 32767},
                                {"uint32", 32, 1, integersOf<uint32_t>, 4294967295},
                                {"int32", 32, 2, integersOf<int32_t>, 2147483647},
                                {"half", 16, 3, pixelOf<half>, 1},
                                {"float", 32, 3, pixelOf<float>, 1},
                                {"double", 64, 3, integersOf<double>, 1}};

struct PixelLayout {
  const char* name;
  unsigned samples, photometric;
  int extra;
  bool isPlanar;
  unsigned tile;
};

const PixelLayout pixelLayouts[] = {{"gray", 1, 1, -1, false, 0},      {"gray tiled", 1, 1, -1, false, 16},
                                    {"gray alpha", 2, 1, 2, false, 0}, {"gray associated", 2, 1, 1, false, 0},
                                    {"RGB", 3, 2, -1, false, 0},       {"RGB tiled", 3, 2, -1, false, 16},
                                    {"RGB planar", 3, 2, -1, true, 0}, {"RGB planar tiled", 3, 2, -1, true, 16},
                                    {"RGBA", 4, 2, 2, false, 0},       {"RGBA associated", 4, 2, 1, false, 0},
                                    {"RGBA planar", 4, 2, 2, true, 0}, {"RGB and another", 4, 2, 0, false, 0}};

TEST_F(MapFormats, TiffOfEveryTypeAndLayoutIsReadOrRejectedByName) {
  for (const PixelType& type : pixelTypes)
    for (const PixelLayout& l : pixelLayouts)
      for (bool isBigEndian : {false, true})
        for (bool isBigTiff : {false, true}) {
          SCOPED_TRACE(std::string(type.name) + " " + l.name + (isBigEndian ? " big-endian" : "") +
                       (isBigTiff ? " BigTIFF" : ""));
          TiffLayout t;
          t.width = t.height = size;
          t.bits = type.bits;
          t.format = type.format;
          t.photometric = l.photometric;
          t.samples = l.samples;
          t.extra = l.extra;
          t.isPlanar = l.isPlanar;
          t.tile = l.tile;
          t.isBigEndian = isBigEndian;
          t.isBigTiff = isBigTiff;
          std::vector<double> pixel;
          for (double x : {0.2, 0.4, 0.6, 0.25}) // two samples: gray and its alpha
            pixel.push_back(std::floor(1024 * x) / 1024 * type.greatest);
          pixel.resize(l.samples);
          const std::string path = pathOf("map.tif");
          writeTiff(path, t, repeated(type.pixel(pixel)));
          const float expected = float(std::floor(type.format == 3 ? 1024 * pixel[0] : pixel[0]) /
                                       (type.format == 3 ? 1024 : type.greatest));
          const Sample found = sampleAt(path, 0.4f, 0.7f);
          if (type.bits == 64 && l.tile) {
            EXPECT_TRUE(containsInOrder(found.error, {path, "tiles", "double"}));
            continue;
          }
          EXPECT_NEAR(found.height, expected, 2e-6) << found.error;
          EXPECT_NEAR(found.mean, expected, 2e-6);
          EXPECT_EQ(found.error + found.warnings, "");
          EXPECT_NEAR(HeightMap::read(path).at(size - 1, size - 1), expected, 1e-6);
        }
}

TEST_F(MapFormats, SignedIntegersRangeFromMinusOneToOne) {
  for (unsigned bits : {8u, 16u, 32u})
    for (double height : {-1.0, -0.25, 0.0, 0.5, 1.0}) {
      constexpr unsigned edge = 100; // larger than a tile of the texture system
      TiffLayout t;
      t.width = t.height = edge;
      t.bits = bits;
      t.format = 2;
      const double greatest = std::ldexp(1.0, int(bits) - 1) - 1, stored = std::round(height * greatest);
      const std::string pixel = bits == 8    ? integersOf<int8_t>({stored})
                                : bits == 16 ? integersOf<int16_t>({stored})
                                             : integersOf<int32_t>({stored});
      std::string samples;
      for (unsigned i = 0; i < edge * edge; i++) samples += pixel;
      const std::string path = pathOf("elevation.tif");
      writeTiff(path, t, samples);
      for (float place : {0.0f, 0.1f, 0.64f}) // where the image repeats, and at the border of a tile
      {
        const Sample found = sampleAt(path, place, place, TextureWrap::Repeat);
        EXPECT_NEAR(found.height, stored / greatest, 1e-6) << bits << " bits, " << height;
        EXPECT_NEAR(found.mean, stored / greatest, 1e-6) << bits << " bits, " << height;
      }
    }
}

/* Equal pixels, in layouts other than the types above. */
TEST_F(MapFormats, TiffOfOtherDepthsAndColorsIsReadOrRejectedByName) {
  struct Case {
    const char* name;
    unsigned bits, format, photometric, samples;
    std::string rows;               // 20 equal pixels each
    float expected;                 // NAN: rejected
    std::vector<std::string> parts; // of the message
  };
  const auto row = [](const std::string& pixel) {
    std::string all;
    for (unsigned i = 0; i < size; i++) all += pixel;
    return all;
  };
  const auto packed = [](unsigned bits, unsigned value) {
    std::string bytes;
    uint64_t buffer = 0;
    unsigned held = 0;
    for (unsigned i = 0; i < size; i++)
      for (buffer = buffer << bits | value, held += bits; held >= 8; held -= 8) bytes += char(buffer >> (held - 8));
    if (held) bytes += char(buffer << (8 - held));
    return bytes;
  };
  const auto u16 = [](std::vector<double> x) { return integersOf<uint16_t>(x); };
  const auto u8 = [](std::vector<double> x) { return integersOf<uint8_t>(x); };
  const Case cases[] = {
      {"bilevel 0", 1, 1, 1, 1, packed(1, 0), 0.0f, {}},
      {"bilevel 1", 1, 1, 1, 1, packed(1, 1), 1.0f, {}},
      {"bilevel 0, white is zero", 1, 1, 0, 1, packed(1, 0), 1.0f, {}},
      {"bilevel 1, white is zero", 1, 1, 0, 1, packed(1, 1), 0.0f, {}},
      {"2 bits", 2, 1, 1, 1, packed(2, 1), 1.0f / 3, {}},
      {"2 bits, white is zero", 2, 1, 0, 1, packed(2, 1), 2.0f / 3, {}},
      {"4 bits", 4, 1, 1, 1, packed(4, 3), 0.2f, {}},
      {"4 bits, white is zero", 4, 1, 0, 1, packed(4, 3), 0.8f, {}},
      {"10 bits", 10, 1, 1, 1, packed(10, 256), 256.0f / 1023, {}},
      {"10 bits, white is zero", 10, 1, 0, 1, packed(10, 256), 767.0f / 1023, {}},
      {"12 bits", 12, 1, 1, 1, packed(12, 1024), 1024.0f / 4095, {}},
      {"12 bits, white is zero", 12, 1, 0, 1, packed(12, 1024), 3071.0f / 4095, {}},
      {"14 bits", 14, 1, 1, 1, packed(14, 4096), 4096.0f / 16383, {}},
      {"8 bits, white is zero", 8, 1, 0, 1, row(u8({51})), 0.8f, {}},
      {"16 bits, white is zero", 16, 1, 0, 1, row(u16({13107})), 0.8f, {}},
      {"16 bits with alpha, white is zero", 16, 1, 0, 2, row(u16({13107, 9999})), 0.8f, {}},
      {"32 bits, white is zero", 32, 1, 0, 1, row(integersOf<uint32_t>({858993459})), 0.8f, {}},
      {"int8, white is zero", 8, 2, 0, 1, row(u8({51})), NAN, {"white", " int8"}},
      {"int16, white is zero", 16, 2, 0, 1, row(u16({51})), NAN, {"white", " int16"}},
      {"int32, white is zero", 32, 2, 0, 1, row(integersOf<uint32_t>({51})), NAN, {"white", " int"}},
      {"half, white is zero", 16, 3, 0, 1, row(u16({51})), NAN, {"white", " half"}},
      {"float, white is zero", 32, 3, 0, 1, row(pixelOf<float>({0.2})), NAN, {"white", " float"}},
      {"double, white is zero", 64, 3, 0, 1, row(integersOf<double>({0.2})), NAN, {"white", " double"}},
      {"uint64", 64, 1, 1, 1, row(std::string(8, 1)), NAN, {"format"}},
      {"int64", 64, 2, 1, 1, row(std::string(8, 1)), NAN, {"format"}},
      {"complex integers", 32, 5, 1, 1, row(std::string(4, 1)), NAN, {"format"}},
      {"complex floats", 64, 6, 1, 1, row(std::string(8, 1)), NAN, {"format"}},
      {"palette of 4 bits", 4, 1, 3, 1, packed(4, 3), 0.2f, {}},
      {"palette of 8 bits", 8, 1, 3, 1, row(u8({51})), 0.2f, {}},
      {"CMYK of 8 bits", 8, 1, 5, 4, row(u8({51, 102, 0, 0})), 0.8f, {}},
      {"CMYK of 16 bits", 16, 1, 5, 4, row(u16({13107, 0, 0, 0})), 0.8f, {}},
      {"YCbCr", 8, 1, 6, 3, row(u8({51, 128, 128})), 0.2f, {}},
      {"Lab, black", 8, 1, 8, 3, row(u8({0, 0, 0})), 0.0f, {}},
  };
  for (const Case& c : cases)
    for (bool isPlanar : {false, true}) {
      if (isPlanar && c.photometric != 5) continue;
      SCOPED_TRACE(std::string(c.name) + (isPlanar ? " planar" : ""));
      TiffLayout t;
      t.width = t.height = size;
      t.bits = c.bits;
      t.format = c.format;
      t.photometric = c.photometric;
      t.samples = c.samples;
      t.isPlanar = isPlanar;
      if (c.photometric == 0 && c.samples == 2) t.extra = 2;
      if (c.photometric == 3)
        for (int color = 0; color < 3; color++)
          for (unsigned i = 0; i < 1u << c.bits; i++)
            t.colors.push_back(uint16_t(color == 0 ? 65535 * i / ((1u << c.bits) - 1) : 0));
      std::string samples;
      for (unsigned y = 0; y < size; y++) samples += c.rows;
      const std::string path = pathOf("map.tif");
      writeTiff(path, t, samples);
      const Sample found = sampleAt(path, 0.4f, 0.7f);
      if (!std::isnan(c.expected)) {
        EXPECT_NEAR(found.height, c.expected, 2e-5) << found.error;
        EXPECT_NEAR(found.mean, c.expected, 2e-5);
        EXPECT_EQ(found.error, "");
        continue;
      }
      EXPECT_TRUE(containsInOrder(found.error, c.parts)) << found.height;
      EXPECT_EQ(found.error.rfind(path, 0), 0u) << found.error;
      EXPECT_EQ(found.error.find('\n'), std::string::npos) << found.error;
    }
}

TEST_F(MapFormats, OtherFilesAreReadIndependentlyOfAlpha) {
  struct Case {
    const char* extension;
    OIIO::TypeDesc type;
    int channels;
    float tolerance;
  };
  using T = OIIO::TypeDesc;
  const Case cases[] = {{"png", T::UINT8, 1, 1e-6f},  {"png", T::UINT8, 2, 1e-6f},  {"png", T::UINT8, 3, 1e-6f},
                        {"png", T::UINT8, 4, 1e-6f},  {"png", T::UINT16, 1, 1e-5f}, {"png", T::UINT16, 2, 1e-5f},
                        {"png", T::UINT16, 3, 1e-5f}, {"png", T::UINT16, 4, 1e-5f}, {"exr", T::HALF, 1, 1e-3f},
                        {"exr", T::HALF, 4, 1e-3f},   {"exr", T::FLOAT, 1, 1e-6f},  {"exr", T::FLOAT, 3, 1e-6f},
                        {"exr", T::UINT32, 1, 1e-6f}, {"tga", T::UINT8, 1, 1e-6f},  {"tga", T::UINT8, 3, 1e-6f},
                        {"tga", T::UINT8, 4, 1e-6f},  {"bmp", T::UINT8, 3, 1e-6f},  {"bmp", T::UINT8, 4, 1e-6f},
                        {"pgm", T::UINT8, 1, 1e-6f},  {"pgm", T::UINT16, 1, 1e-5f}, {"ppm", T::UINT8, 3, 1e-6f},
                        {"hdr", T::FLOAT, 3, 4e-3f},  {"dpx", T::UINT16, 3, 1e-3f}, {"dpx", T::UINT8, 4, 1e-6f},
                        {"sgi", T::UINT8, 1, 1e-6f},  {"sgi", T::UINT16, 4, 1e-5f}, {"iff", T::UINT8, 4, 1e-6f},
                        {"jpg", T::UINT8, 1, 2e-2f},  {"jpg", T::UINT8, 3, 2e-2f},  {"rla", T::UINT16, 3, 1e-5f},
                        {"rla", T::FLOAT, 3, 1e-6f}};
  const float color[] = {0.8f, 0.6f, 0.4f};
  for (const Case& c : cases) {
    SCOPED_TRACE(std::string(c.extension) + " " + c.type.c_str() + " x" + std::to_string(c.channels));
    const std::string path = pathOf(std::string("map.") + c.extension);
    const auto output = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(output) << OIIO::geterror();
    OIIO::ImageSpec spec(size, size, c.channels, c.type);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    if (c.channels == 2) spec.channelnames = {"Y", "A"}, spec.alpha_channel = 1;
    std::vector<float> pixel(color, color + std::min(c.channels, 3));
    if (c.channels % 2 == 0) pixel.resize(size_t(c.channels) - 1), pixel.push_back(0.25f);
    std::vector<float> pixels;
    for (unsigned i = 0; i < size * size; i++) pixels.insert(pixels.end(), pixel.begin(), pixel.end());
    ASSERT_TRUE(output->open(path, spec) && output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) &&
                output->close())
        << output->geterror();
    const Sample found = sampleAt(path, 0.4f, 0.7f);
    EXPECT_NEAR(found.height, 0.8f, c.tolerance) << found.error;
  }
}

/* Writes 4 x 2 heights of 0.9 into a display window, by default of 8 x 8. */
std::string writeWindow(const std::string& path, int x, int y, int fullX = 0, int fullY = 0, int fullSize = 8,
                        int tile = 0) {
  const auto output = OIIO::ImageOutput::create(path);
  OIIO::ImageSpec spec(4, 2, 1, OIIO::TypeDesc::FLOAT);
  spec.x = x;
  spec.y = y;
  spec.full_x = fullX;
  spec.full_y = fullY;
  spec.full_width = spec.full_height = fullSize;
  spec.tile_width = spec.tile_height = tile;
  const std::vector<float> heights(8, 0.9f);
  EXPECT_TRUE(output->open(path, spec)) << output->geterror();
  EXPECT_TRUE(tile ? output->write_image(OIIO::TypeDesc::FLOAT, heights.data())
                   : output->write_scanlines(y, y + 2, 0, OIIO::TypeDesc::FLOAT, heights.data()));
  output->close();
  return path;
}

TEST_F(MapFormats, TexelsOutsideOfTheDataWindowAreNeutral) {
  struct Place {
    float s, t, expected;
  };
  const auto check = [](const std::string& path, const std::vector<Place>& places) {
    for (TextureWrap wrap : {TextureWrap::Clamp, TextureWrap::Repeat})
      for (const Place& p : places)
        EXPECT_FLOAT_EQ(sampleAt(path, p.s, p.t, wrap).height, p.expected) << path << " at " << p.s << "," << p.t;
    EXPECT_EQ(sampleAt(path, 0, 0).warnings, "");
  };
  const float half = 0.5f;
  const auto texel = [](int i, int of = 8) { return (float(i) + 0.5f) / float(of); };
  /* data from 2,3 to 5,4; bicubic filters extend over two texels, so sample beyond that */
  const std::string cropped = writeWindow(pathOf("cropped.exr"), 2, 3);
  check(cropped, {{texel(0), texel(0), half}, {texel(3), texel(7), half}, {texel(7), texel(6), half}});
  const HeightMap map = HeightMap::read(writeWindow(pathOf("full.exr"), 0, 0, 0, 0, 2));
  EXPECT_EQ(map.width(), 2) << "texels outside of the display window are not part of the map";
  EXPECT_EQ(map.at(1, 1), 0.9f);
  for (int tile : {0, 16})
    for (int shift : {-3, 0, 5}) {
      std::string warnings;
      const std::string path = writeWindow(pathOf("shifted.exr"), 2 + shift, 3 + shift, shift, shift, 8, tile);
      const HeightTexture texture({path}, {"", 1, 0.25f}, TextureWrap::Clamp, warnings);
      EXPECT_EQ(texture.size(0).x, 8.0f);
      EXPECT_TRUE(texture.hasConstantBorder());
      float height = 0, around = 0;
      texture.sample(0, 0.5f, 0.5f, 0.0f, 0.0f, &height); // between the middle columns, at the lower edge of the data
      texture.sample(0, 0.5f, texel(0), 0.0f, 0.0f, &around);
      EXPECT_GT(height, 0.8f) << shift;
      EXPECT_FLOAT_EQ(around, 0.25f) << shift;
    }
  /* a data window that is offset by its own size has no texel in the display window */
  check(writeWindow(pathOf("beside.exr"), 8, 8), {{texel(1), texel(1), half}, {texel(6), texel(6), half}});
  /* a position on a page, which PNG stores and TIFF stores without Pixar's tags, is not a display window */
  check(writeWindow(pathOf("placed.png"), 5, 1), {{0.5f, 0.5f, 230.0f / 255.0f}, {0.1f, 0.1f, 230.0f / 255.0f}});
  const std::string pixar = writeWindow(pathOf("cropped.tif"), 2, 3);
  check(pixar, {{texel(0), texel(0), half}, {texel(3), texel(7), half}});
}

TEST_F(MapFormats, MissingTexelsAreNeutralAndCounted) {
  struct Case {
    const char* name;
    unsigned bits, format, photometric;
    const char* nodata;
    std::string missing, other; // samples
    float expected;             // value of the other samples
  };
  const auto f = [](double x) { return integersOf<float>({x}); };
  const auto f64 = [](double x) { return integersOf<double>({x}); };
  const auto i32 = [](double x) { return integersOf<int32_t>({x}); };
  const auto u32 = [](double x) { return integersOf<uint32_t>({x}); };
  const auto i16 = [](double x) { return integersOf<int16_t>({x}); };
  const auto u16 = [](double x) { return integersOf<uint16_t>({x}); };
  const auto u8 = [](double x) { return integersOf<uint8_t>({x}); };
  const Case cases[] = {
      {"NaN", 32, 3, 1, "", f(NAN), f(0.9), 0.9f},
      {"lowest float", 32, 3, 1, "", f(-3.402823466e38), f(0.9), 0.9f},
      {"rounded lowest float", 32, 3, 1, "", f(-3.4e38), f(0.9), 0.9f},
      {"GDAL's text of the lowest float", 32, 3, 1, "-3.4028234663852886e+38", f(-3.402823466e38), f(0.9), 0.9f},
      {"float", 32, 3, 1, "-9999", f(-9999), f(0.9), 0.9f},
      {"float that is not exact", 32, 3, 1, "0.1", f(0.1f), f(0.9), 0.9f},
      {"float with blanks and a sign", 32, 3, 1, " +1e+20 ", f(1e20), f(0.9), 0.9f},
      {"infinity", 32, 3, 1, "-inf", f(-INFINITY), f(0.9), 0.9f},
      {"lowest double for floats", 32, 3, 1, "-1.7976931348623157e+308", f(-INFINITY), f(0.9), 0.9f},
      {"nan in the tag", 32, 3, 1, "nan", f(NAN), f(0.9), 0.9f},
      {"double", 64, 3, 1, "-1.7976931348623157e+308", f64(-1.7976931348623157e308), f64(0.9), 0.9f},
      {"half", 16, 3, 1, "-9999", pixelOf<half>({-10000}), pixelOf<half>({0.75}), 0.75f},
      {"int16", 16, 2, 1, "-32768", i16(-32768), i16(-32767), -1.0f},
      {"int16 of SRTM", 16, 2, 1, "-9999", i16(-9999), i16(-9998), -9998.0f / 32767},
      {"int8", 8, 2, 1, "-128", integersOf<int8_t>({-128}), integersOf<int8_t>({127}), 1.0f},
      {"int32, next to another", 32, 2, 1, "-2147483648", i32(-2147483648.0), i32(-2147483647.0), -1.0f},
      {"uint8", 8, 1, 1, "255", u8(255), u8(254), 254.0f / 255},
      {"uint8, white is zero", 8, 1, 0, "255", u8(255), u8(0), 1.0f},
      {"uint16", 16, 1, 1, "0", u16(0), u16(1), 1.0f / 65535},
      {"uint16, white is zero", 16, 1, 0, "0", u16(0), u16(65535), 0.0f},
      {"uint32", 32, 1, 1, "4294967295", u32(4294967295.0), u32(4294967294.0), 1.0f},
  };
  for (const Case& c : cases)
    for (bool isBig : {false, true}) {
      SCOPED_TRACE(std::string(c.name) + (isBig ? ", big-endian BigTIFF" : ""));
      TiffLayout t;
      t.width = t.height = size;
      t.bits = c.bits;
      t.format = c.format;
      t.photometric = c.photometric;
      t.nodata = c.nodata;
      t.isBigEndian = t.isBigTiff = isBig;
      if (c.name == std::string("half")) t.nodata = "-10000"; // half does not represent -9999
      std::string samples;
      for (unsigned i = 0; i < size * size; i++) samples += i % size < 10 ? c.missing : c.other; // the left half
      const std::string path = pathOf("map.tif");
      writeTiff(path, t, samples);
      const Sample missing = sampleAt(path, 0.1f, 0.5f, TextureWrap::Clamp, 0.25f), other = sampleAt(path, 0.9f, 0.5f);
      EXPECT_EQ(missing.error, "");
      EXPECT_FLOAT_EQ(missing.height, 0.25f);
      EXPECT_NEAR(other.height, c.expected, 1e-6f);
      EXPECT_EQ(missing.warnings, path + ": 200 texels have no value and displace nothing\n");
    }
}

TEST_F(MapFormats, ValuesThatResembleMissingOnesAreHeights) {
  TiffLayout t;
  t.width = t.height = size;
  const std::string path = pathOf("map.tif");
  for (const char* nodata : {"-9999", "256", "12.5", "none", "", "1e999", "nan", "-"}) {
    t.nodata = nodata;
    writeTiff(path, t, repeated(std::string(1, 12)));
    EXPECT_FLOAT_EQ(sampleAt(path, 0.5f, 0.5f).height, 12.0f / 255) << nodata;
    EXPECT_EQ(sampleAt(path, 0.5f, 0.5f).warnings, "") << nodata;
  }
  t.bits = 32;
  t.format = 3;
  for (const char* nodata : {"", "nan", "-9999"}) {
    t.nodata = nodata;
    writeTiff(path, t, repeated(bytesOf(std::vector<float>{INFINITY})));
    EXPECT_TRUE(containsInOrder(sampleAt(path, 0.5f, 0.5f).error, {path, " 0,0 ", "finite"})) << nodata;
  }
}

TEST_F(MapFormats, EachPageHasItsOwnMissingValue) {
  TiffWriter writer(false, false);
  TiffLayout t;
  t.width = t.height = size;
  for (const char* nodata : {"1", "", "3"}) {
    t.nodata = nodata;
    writer.addPage(t, repeated(std::string(1, 1)));
  }
  const std::string path = pathOf("pages.tif");
  writer.save(path);
  std::string warnings;
  const HeightTexture texture({path}, {"", 1, 0.5f}, TextureWrap::Clamp, warnings);
  ASSERT_EQ(texture.numImages(), 3u);
  for (unsigned image = 0; image < 3; image++) {
    float height = 0;
    texture.sample(image, 0.5f, 0.5f, 0.0f, 0.0f, &height);
    EXPECT_FLOAT_EQ(height, image == 0 ? 0.5f : 1.0f / 255) << image;
  }
  EXPECT_TRUE(containsInOrder(warnings, {path, " 400 texels"}));
  EXPECT_EQ(warnings.find('\n'), warnings.size() - 1) << warnings;
}

TEST_F(MapFormats, SmallerCopiesAndMasksAreIgnored) {
  for (unsigned tile : {0u, 16u}) {
    TiffWriter writer(false, false);
    for (unsigned page = 0; page < 2; page++)
      for (unsigned subfile : {0u, 1u, 1u, 4u, 5u}) // a page, two copies of it, its mask and a copy of the mask
      {
        TiffLayout t;
        t.width = t.height = size;
        t.tile = tile;
        t.subfile = subfile;
        writer.addPage(t, repeated(std::string(1, char(subfile ? 99 : 10 + page))));
      }
    const std::string path = pathOf("overviews.tif");
    writer.save(path);
    std::string warnings;
    const HeightTexture texture({path}, {}, TextureWrap::Clamp, warnings);
    ASSERT_EQ(texture.numImages(), 2u);
    for (unsigned page = 0; page < 2; page++) {
      float height = 0;
      texture.sample(page, 0.5f, 0.5f, 0.0f, 0.0f, &height);
      EXPECT_FLOAT_EQ(height, float(10 + page) / 255);
    }
  }
}

TEST_F(MapFormats, FileWithAnUnreadablePageIsRejected) {
  TiffWriter writer(false, false);
  TiffLayout t;
  t.width = t.height = size;
  writer.addPage(t, repeated("a"));
  t.format = 2;
  t.photometric = 0;
  writer.addPage(t, repeated("a"));
  const std::string path = pathOf("pages.tif");
  writer.save(path);
  EXPECT_TRUE(containsInOrder(sampleAt(path, 0.5f, 0.5f).error, {path, "image 1", "white", " int8"}));
}

TEST_F(MapFormats, DeepImagesAreRejected) {
  const std::string path = pathOf("deep.exr");
  OIIO::ImageSpec spec(4, 4, 1, OIIO::TypeDesc::FLOAT);
  spec.deep = true;
  const auto output = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(output->open(path, spec) && output->write_deep_image(OIIO::DeepData(spec)) && output->close())
      << output->geterror();
  EXPECT_TRUE(containsInOrder(sampleAt(path, 0.5f, 0.5f).error, {path, "deep"}));
}

TEST_F(MapFormats, MissingFilesThatResembleTilesSuggestAPlaceholder) {
  for (const char* name : {"skin_u1_v1.exr", "skin.1001.exr", "skin.<TILE>.exr", "skin.%(tile)d.exr"})
    EXPECT_TRUE(containsInOrder(sampleAt(pathOf(name), 0.5f, 0.5f).error, {pathOf(name), "<UDIM>", "<UVTILE>"}));
  const std::string error = sampleAt(pathOf("skin.exr"), 0.5f, 0.5f).error;
  EXPECT_EQ(error.rfind(pathOf("skin.exr") + ": ", 0), 0u) << error;
  EXPECT_EQ(error.find('<'), std::string::npos) << error;
}

TEST_F(MapFormats, PipesAreRejectedWithoutOpeningThem) {
  const std::string path = pathOf("pipe.exr");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_EQ(sampleAt(path, 0.5f, 0.5f).error.rfind(path + ": ", 0), 0u);
  EXPECT_TRUE(containsInOrder(sampleAt(path, 0.5f, 0.5f).error, {"pipe", "device"}));
  EXPECT_THROW(HeightMap::read(path), Error);
  EXPECT_EQ(HeightMap::recipeOf(path), "");
}

}} // namespace programs::test
