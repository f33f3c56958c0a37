// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Maps whose texels all differ, written by other means than OpenImageIO's writers, whose errors its readers may share:
 * the height of each texel, or the error message. */

#include "basics/error.h"
#include "support/map_files.h"
#include "support/message_parts.h"
#include "support/tiff_file.h"
#include "surface/height_map.h"
#include "surface/height_texture.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace programs::test { namespace {

constexpr int width = 23, height = 13;

/* Linear, so that filters reproduce it, and different for each texel. */
float rampAt(int x, int y) { return 0.1f + 0.02f * float(x) + 0.027f * float(y); }

using MapReaders = MapFiles;

/* Each texel of a map of rampAt(), as read and as filtered. */
void expectRamp(const std::string& path, float tolerance) {
  SCOPED_TRACE(path);
  const HeightMap map = HeightMap::read(path);
  ASSERT_EQ(map.width(), width);
  ASSERT_EQ(map.height(), height);
  std::string warnings;
  const HeightTexture texture({path}, {"", 1, 0.5f}, TextureWrap::Clamp, warnings);
  constexpr int border = 2; // where bicubic filters repeat the border's texels
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++) {
      ASSERT_NEAR(map.at(x, y), rampAt(x, y), tolerance) << x << "," << y;
      float sampled = NAN;
      texture.sample(0, (float(x) + 0.5f) / width, (float(y) + 0.5f) / height, 0.0f, 0.0f, &sampled);
      if (x >= border && x < width - border && y >= border && y < height - border) {
        ASSERT_NEAR(sampled, rampAt(x, y), tolerance) << x << "," << y;
      }
    }
}

/* A PGM or PPM of rampAt(). type: '2', '3', '5' or '6'. */
std::string pnmOf(char type, unsigned most) {
  std::string file = std::string("P") + type + " # a comment\n" + std::to_string(width) + "\n" +
                     std::to_string(height) + " " + std::to_string(most) + "\n";
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++)
      for (int channel = 0; channel < (type == '3' || type == '6' ? 3 : 1); channel++) {
        const unsigned value = unsigned(std::lround(rampAt(x, y) * float(most))) - (channel ? 1 : 0);
        if (type < '4') file += std::to_string(value) + (x % 8 ? " " : "\n# and another\n");
        else file += (most > 255 ? std::string(1, char(value >> 8)) : "") + char(value);
      }
  return file;
}

TEST_F(MapReaders, PgmAndPpmOfEveryMaximumAreReadExactly) {
  for (char type : {'2', '3', '5', '6'})
    for (unsigned most : {99u, 255u, 256u, 1023u, 32768u, 32769u, 40000u, 60000u, 65535u})
      expectRamp(save(std::string("p") + type + "_" + std::to_string(most) + ".pgm", pnmOf(type, most)),
                 0.5f / float(most) + 1e-6f);
}

TEST_F(MapReaders, LargestSampleOfPgmIsOne) {
  for (unsigned most : {1u, 127u, 255u, 300u, 40000u, 65535u}) {
    const std::string sample = (most > 255 ? std::string(1, char(most >> 8)) : "") + char(most);
    const std::string path = save("one.pgm", "P5 1 1 " + std::to_string(most) + "\n" + sample);
    EXPECT_EQ(HeightMap::read(path).at(0, 0), 1.0f) << most;
    EXPECT_EQ(valueAt(path), 1.0f) << most;
  }
}

TEST_F(MapReaders, BitmapsAreReadWithAndWithoutBlanks) {
  for (const std::string& file :
       {std::string("P1\n3 2\n1 0 1\n0 0 1\n"), std::string("P1 3 2 101001"), std::string("P4 3 2\n\xA0\x20")}) {
    const HeightMap map = HeightMap::read(save("bits.pbm", file));
    for (int i = 0; i < 6; i++)
      EXPECT_EQ(map.at(i % 3, i / 3), i == 0 || i == 2 || i == 5 ? 0.0f : 1.0f) << file << ", texel " << i;
  }
}

/* A PFM of rampAt() times `factor`. */
std::string pfmOf(int channels, bool isLittleEndian, float factor, const std::string& scale) {
  std::string file = std::string(channels == 1 ? "Pf" : "PF") + "\n" + std::to_string(width) + " " +
                     std::to_string(height) + "\n" + (isLittleEndian ? "-" : "") + scale + "\n";
  for (int y = height - 1; y >= 0; y--)
    for (int i = 0; i < width * channels; i++) {
      const float sample = factor * rampAt(i / channels, y);
      uint32_t bits;
      std::memcpy(&bits, &sample, sizeof bits);
      for (int byte = 0; byte < 4; byte++) file += char(bits >> 8 * (isLittleEndian ? byte : 3 - byte));
    }
  return file;
}

TEST_F(MapReaders, PfmIsReadInBothByteOrdersFromTheBottom) {
  for (int channels : {1, 3})
    for (bool isLittleEndian : {false, true}) {
      expectRamp(save("a.pfm", pfmOf(channels, isLittleEndian, 1.0f, "1.0")), 1e-6f);
      expectRamp(save("b.pfm", pfmOf(channels, isLittleEndian, 4.0f, "0.25")), 1e-6f);
    }
}

TEST_F(MapReaders, DamagedPnmIsRejectedByName) {
  const std::string gray = pnmOf('5', 40000), text = pnmOf('2', 40000), floats = pfmOf(1, true, 1, "1");
  const struct {
    std::string file;
    std::vector<std::string> parts;
  } cases[] = {{gray.substr(0, gray.size() - 1), {"truncated", "598", "597"}},
               {text.substr(0, text.size() / 2), {"sample", " 299 "}},
               {floats.substr(0, floats.size() / 2), {"truncated", "1196"}},
               {"P5 0 3 255\n", {"width", "1"}},
               {"P5 3\n", {"height"}},
               {"P5 3 2 0\n123456", {"maximum", "65535"}},
               {"P5 3 2 65536\n123456", {"maximum", "65535"}},
               {"P5 3 2 99\n12345\x7f", {" 2,1 ", "127", "99"}},
               {"P2 3 2 9 1 2 3 4 10 6", {" 1,1 ", "10", "9"}},
               {"P2 3 2 9 1 2 3 4 300 6", {"300", "9"}},
               {"P1 2 1 12", {"sample 1 of 2"}},
               {"Pf 1 1 0\n1234", {"scale", "0"}},
               {"Pf 1 1 nan\n1234", {"scale"}},
               {"P5", {"P5"}}};
  for (const auto& c : cases) {
    const std::string path = save("damaged_P5.pgm", c.file);
    std::vector<std::string> parts{path};
    parts.insert(parts.end(), c.parts.begin(), c.parts.end());
    if (c.file == "P5") parts.pop_back();
    EXPECT_TRUE(containsInOrder(errorOf(path), parts)) << c.file.substr(0, 20);
    EXPECT_THROW(HeightMap::read(path), Error);
  }
}

/* Data of PNG, uncompressed. */
std::string pngOf(int bits, bool hasAlpha) {
  const auto big = [](uint32_t value, int bytes) {
    std::string text;
    for (int byte = bytes - 1; byte >= 0; byte--) text += char(value >> 8 * byte);
    return text;
  };
  const auto chunk = [&](const std::string& name, const std::string& data) {
    uint32_t crc = ~0u;
    for (char c : name + data) {
      crc ^= uint8_t(c);
      for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0u);
    }
    return big(uint32_t(data.size()), 4) + name + data + big(~crc, 4);
  };
  std::string raw;
  const float most = float((1 << bits) - 1);
  for (int y = 0; y < height; y++) {
    raw += '\0';
    for (int x = 0; x < width; x++) {
      raw += big(uint32_t(std::lround(rampAt(x, y) * most)), bits / 8);
      if (hasAlpha) raw += big(uint32_t(x * 5), bits / 8);
    }
  }
  uint32_t a = 1, b = 0;
  for (char c : raw) b = (b + (a = (a + uint8_t(c)) % 65521)) % 65521;
  const std::string size{char(raw.size() & 255), char(raw.size() >> 8), char(~raw.size() & 255),
                         char(~raw.size() >> 8 & 255)};
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR", big(width, 4) + big(height, 4) + char(bits) + char(hasAlpha ? 4 : 0) + std::string(3, '\0')) +
         chunk("IDAT", "\x78\x01\x01" + size + raw + big(b << 16 | a, 4)) + chunk("IEND", "");
}

TEST_F(MapReaders, GrayOfPngIsReadIndependentlyOfAlpha) {
  for (int bits : {8, 16})
    for (bool hasAlpha : {false, true})
      expectRamp(save("gray.png", pngOf(bits, hasAlpha)), 0.5f / float((1 << bits) - 1) + 1e-6f);
}

template<typename T>
void appendSample(std::string& samples, double value) {
  const T sample = T(std::is_floating_point_v<T> ? value : std::round(value * double(std::numeric_limits<T>::max())));
  samples.append(reinterpret_cast<const char*>(&sample), sizeof sample);
}

TEST_F(MapReaders, TexelsOfTiffAreReadInTheirPlaces) {
  const struct {
    const char* name;
    unsigned bits, format;
    void (*append)(std::string& samples, double value);
    float tolerance;
  } types[] = {{"uint8", 8, 1, appendSample<uint8_t>, 2e-3f},    {"int8", 8, 2, appendSample<int8_t>, 4e-3f},
               {"uint16", 16, 1, appendSample<uint16_t>, 1e-5f}, {"int16", 16, 2, appendSample<int16_t>, 2e-5f},
               {"uint32", 32, 1, appendSample<uint32_t>, 1e-6f}, {"int32", 32, 2, appendSample<int32_t>, 1e-6f},
               {"float", 32, 3, appendSample<float>, 1e-6f},     {"double", 64, 3, appendSample<double>, 1e-6f}};
  for (const auto& type : types)
    for (unsigned samples : {1u, 2u, 3u, 4u})
      for (unsigned tile : {0u, 16u})
        for (bool isPlanar : {false, true}) {
          if ((tile && type.bits == 64) || (isPlanar && samples < 3)) continue;
          SCOPED_TRACE(std::string(type.name) + " x" + std::to_string(samples) + (tile ? " tiled" : "") +
                       (isPlanar ? " planar" : ""));
          TiffLayout t;
          t.width = width;
          t.height = height;
          t.bits = type.bits;
          t.format = type.format;
          t.photometric = samples < 3 ? 1 : 2;
          t.samples = samples;
          t.extra = samples % 2 ? -1 : 2;
          t.isPlanar = isPlanar;
          t.tile = tile;
          std::string bytes;
          for (int i = 0; i < width * height; i++)
            for (unsigned channel = 0; channel < samples; channel++)
              type.append(bytes, channel == 0 ? rampAt(i % width, i / width) : 0.01 * (i % width));
          const std::string path = pathOf("map.tif");
          writeTiff(path, t, bytes);
          expectRamp(path, type.tolerance);
        }
}

/* Radiance HDR of rampAt(), in this order of rows and columns. */
std::string hdrOf(bool isFromTop, bool isFromLeft) {
  std::string file = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
  file += (isFromTop ? "-Y " : "+Y ") + std::to_string(height);
  file += (isFromLeft ? " +X " : " -X ") + std::to_string(width) + "\n";
  for (int i = 0; i < width * height; i++) {
    int exponent;
    const float height01 =
        rampAt(isFromLeft ? i % width : width - 1 - i % width, isFromTop ? i / width : height - 1 - i / width);
    const auto mantissa = char(int(256 * std::frexp(height01, &exponent)));
    file += std::string(3, mantissa) + char(128 + exponent);
  }
  return file;
}

TEST_F(MapReaders, HdrOfOtherOrdersIsRejectedByName) {
  expectRamp(save("map.hdr", hdrOf(true, true)), 4e-3f);
  for (bool isFromTop : {false, true})
    for (bool isFromLeft : {false, true})
      if (!isFromTop || !isFromLeft) {
        const std::string path = save("map.hdr", hdrOf(isFromTop, isFromLeft));
        EXPECT_TRUE(containsInOrder(errorOf(path), {path, "order", "top"}));
      }
}

/* Softimage PIC of rampAt(), with rows as literals if isPacked. */
std::string softimageOf(bool isPacked) {
  using namespace std::string_literals;
  std::string file = "\x53\x80\xF6\x34\x40\x6c\xcc\xcd"s + std::string(80, '\0') + "PICT"s;
  file += "\0"s + char(width) + "\0"s + char(height) + "\x3f\x80\0\0\0\3\0\0"s; // aspect ratio, both fields
  file += "\0\x8"s + char(isPacked ? 2 : 0) + "\xE0"s;
  for (int y = 0; y < height; y++) {
    if (isPacked) file += char(width - 1);
    for (int x = 0; x < width; x++) file += std::string(3, char(std::lround(255 * rampAt(x, y))));
  }
  return file;
}

TEST_F(MapReaders, SoftimageIsReadOrRejectedByName) {
  expectRamp(save("map.pic", softimageOf(true)), 2e-3f);
  const std::string path = save("map.pic", softimageOf(false));
  if (OIIO::openimageio_version() >= 30000) expectRamp(path, 2e-3f);
  else EXPECT_TRUE(containsInOrder(errorOf(path), {path, "Softimage", "TIFF"}));
}

TEST_F(MapReaders, FitsIsRejectedByName) {
  std::string file;
  for (const char* card :
       {"SIMPLE  =                    T", "BITPIX  =                    8", "NAXIS   =                    2",
        "NAXIS1  =                    2", "NAXIS2  =                    2", "END"})
    file += card + std::string(80 - std::strlen(card), ' ');
  file.resize(2880, ' ');
  file += "1234";
  file.resize(2 * 2880, '\0');
  const std::string path = save("map.fits", file);
  EXPECT_TRUE(containsInOrder(errorOf(path), {path, "FITS", "TIFF"}));
}

/* A codestream of 8 x 6 unsigned bytes, 20x + 10y, with one level and without loss. */
std::string jpeg2000() {
  const unsigned char bytes[] = {
      0xff, 0x4f, 0xff, 0x51, 0x00, 0x29, 0x00, 0x00, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00, 0x06, 0x00, 0x00,
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00, 0x06, 0x00, 0x00, 0x00, 0x00,
      0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x07, 0x01, 0x01, 0xff, 0x52, 0x00, 0x0c, 0x00, 0x00, 0x00, 0x01, 0x00,
      0x00, 0x04, 0x04, 0x00, 0x01, 0xff, 0x5c, 0x00, 0x04, 0x40, 0x40, 0xff, 0x90, 0x00, 0x0a, 0x00, 0x00, 0x00,
      0x00, 0x00, 0x38, 0x00, 0x01, 0xff, 0x93, 0xdf, 0x81, 0x38, 0x12, 0x28, 0x19, 0xc7, 0x81, 0xbc, 0x99, 0x38,
      0xa6, 0x4b, 0x3c, 0x38, 0x3c, 0x70, 0xaa, 0x4d, 0x6f, 0x3d, 0xa5, 0xe2, 0xd2, 0x62, 0x32, 0x6b, 0x1d, 0x0d,
      0xb7, 0x4e, 0xcf, 0xb3, 0xa7, 0x4d, 0x40, 0x20, 0x1f, 0x20, 0x74, 0x91, 0x47, 0xff, 0xd9};
  return std::string(reinterpret_cast<const char*>(bytes), sizeof bytes);
}

constexpr size_t signOfComponent = 42, endOfWidth = 11, endOfOrigin = 19; // positions in the codestream

/* The boxes of a JP2 file, with another one before the codestream. */
std::string jp2(const std::string& codestream) {
  const auto box = [](const std::string& name, const std::string& content) {
    return std::string(3, '\0') + char(content.size() + 8) + name + content;
  };
  using namespace std::string_literals;
  const std::string header = box("ihdr", "\0\0\0\6\0\0\0\x8\0\1\7\7\0\0"s) + box("colr", "\1\0\0\0\0\0\x11"s);
  return box("jP  ", "\r\n\x87\n") + box("ftyp", "jp2 \0\0\0\0jp2 "s) + box("jp2h", header) +
         box("xml ", "<a>" + std::string(90, ' ') + "</a>") + box("jp2c", codestream);
}

TEST_F(MapReaders, Jpeg2000IsReadOrRejectedByName) {
  const auto formats = OIIO::get_string_attribute("input_format_list");
  if (formats.find("jpeg2000") == std::string::npos) GTEST_SKIP() << "this OpenImageIO does not read JPEG 2000";
  const std::string plain = jpeg2000();
  std::string isSigned = plain, isMoved = plain;
  isSigned[signOfComponent] = char(isSigned[signOfComponent] | 0x80);
  isMoved[endOfWidth] = char(isMoved[endOfWidth] + 1);
  isMoved[endOfOrigin] = 1;
  for (bool isBoxed : {false, true}) {
    const auto file = [&](const std::string& codestream) {
      return save(isBoxed ? "map.jp2" : "map.j2k", isBoxed ? jp2(codestream) : codestream);
    };
    const HeightMap map = HeightMap::read(file(plain));
    ASSERT_EQ(map.width(), 8);
    for (int i = 0; i < 48; i++) EXPECT_NEAR(map.at(i % 8, i / 8), float(20 * (i % 8) + 10 * (i / 8)) / 255, 1e-6f);
    const std::string path = file(isSigned);
    EXPECT_TRUE(containsInOrder(errorOf(path), {path, "JPEG 2000", "signed", "TIFF"}));
    EXPECT_TRUE(containsInOrder(errorOf(file(isMoved)), {path, "JPEG 2000", " 1,0", "TIFF"}));
  }
}

TEST_F(MapReaders, WebpWithAlphaIsRejectedByName) {
  if (OIIO::get_string_attribute("output_format_list").find("webp") == std::string::npos)
    GTEST_SKIP() << "this OpenImageIO does not write WebP";
  for (int channels : {3, 4}) {
    const std::string path = pathOf("map.webp");
    const auto output = OIIO::ImageOutput::create(path);
    const std::vector<float> color(size_t(64 * channels), 0.5f);
    ASSERT_TRUE(output->open(path, OIIO::ImageSpec(8, 8, channels, OIIO::TypeDesc::UINT8)) &&
                output->write_image(OIIO::TypeDesc::FLOAT, color.data()) && output->close());
    if (channels == 4) EXPECT_TRUE(containsInOrder(errorOf(path), {path, "WebP", "alpha", "PNG"}));
    else EXPECT_NEAR(valueAt(path), 0.5f, 0.02f);
  }
}

TEST_F(MapReaders, ImagesThatOpenImageIoMakesUpAreRejected) {
  const std::string path = save("map.null", "any bytes");
  EXPECT_TRUE(containsInOrder(errorOf(path), {path, "extension"}));
}

}} // namespace programs::test
