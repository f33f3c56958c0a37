// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* One float per texel, read by OpenImageIO. Unsigned integers become 0..1, signed integers -1..1: an int16 file of
 * elevations in meters needs a mid level of 0 and a scale of 32767 meters. Colors are not multiplied by alpha. Row 0
 * is the top. */

#include <cstddef>
#include <string>
#include <vector>

namespace programs {

class HeightMap {
public:
  HeightMap() = default;
  HeightMap(int width, int height) : w(width), h(height), texels(size_t(width) * height) {}

  /* Reads the first image's channel that inspect() finds for an empty name. Throws Error with the path if the file is
   * unreadable or a texel is missing or not finite. */
  static HeightMap read(const std::string& path);

  struct FileInfo {
    unsigned images = 0;            // Ptex: one per face; also pages of a TIFF, parts of an EXR
    std::vector<int> numbers;       // of the images: a TIFF also contains smaller copies and masks
    std::vector<int> firstChannels; // of the requested channels, per image of the file
    int channels = 0;               // of the first image
    int tileSize = 0;               // smallest edge of tiles, or 0 without tiles
    bool constantBorder = false;    // of the first image
    bool isTextureReadable = true;  // the texture system can read the file itself, see map_image.h
    size_t missing = 0;             // texels without a value
  };

  /* Reads `count` channels of all images. `channel` is the first one: a name, a number from 0, or empty for "height",
   * otherwise for the first channels without alpha. Parts of an EXR without a channel of this name are left out;
   * PART.CHANNEL names one in a part. Texels without a value (NaN, -3.4e38, GDAL's nodata) or outside an image's data
   * window read as `neutral`. Throws Error as read() does, and if the file lacks the channels. */
  static FileInfo inspect(const std::string& path, const std::string& channel = "", int count = 1,
                          float neutral = 0.0f);

  /* Writes one uncompressed float channel "height", completely or not at all. OpenEXR's compression DWA, which other
   * programs may apply later, is lossy for channels named Y, R, G or B only. `recipe` describes how the map was made
   * and is stored in the header. Throws Error. */
  void write(const std::string& path, const std::string& recipe = "") const;

  /* Empty without a recipe, and if the file is not an image. */
  static std::string recipeOf(const std::string& path);

  int width() const { return w; }
  int height() const { return h; }
  float& at(int x, int y) { return texels[size_t(y) * w + x]; }
  float at(int x, int y) const { return texels[size_t(y) * w + x]; }

  /* Bilinear, in texels, clamped. (0,0) is the center of the first texel. */
  float sampleTexels(float x, float y) const;

private:
  int w = 0, h = 0;
  std::vector<float> texels;
};

} // namespace programs
