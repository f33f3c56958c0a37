// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height maps: one float per texel, read by OpenImageIO from float EXR, 16-bit PNG or TIFF and its other formats.
 * Unsigned integers become 0..1, signed integers -1..1, so an int16 file of elevations in meters needs a mid level of
 * 0 and a scale of 32767 meters. Colors are not multiplied by alpha. Row 0 is the top of the image. */

#include <cstddef>
#include <string>
#include <vector>

namespace cbvh {

class HeightMap
{
public:
  HeightMap() = default;
  HeightMap(int width, int height) : w(width), h(height), texels(size_t(width) * height) {}

  /* Reads the first channel of an image. Throws Error, one line that starts with the path, for a file that is missing,
   * unreadable or truncated, and for texels that are missing or not finite. */
  static HeightMap read(const std::string& path);

  /* Describes a file whose images were all read and found valid. */
  struct FileInfo
  {
    unsigned images = 0;         // one per face in Ptex files; pages of a TIFF, parts of an EXR
    std::vector<int> numbers;    // of the images within the file: a TIFF also contains smaller copies and masks
    int firstChannel = 0;        // the first of the requested channels
    int channels = 0;            // channels of the first image
    bool constantBorder = false; // of the first image
    bool isPlain = true;         // the texture system reads the same texels directly from the file, see map_image.h
    size_t missing = 0;          // texels without a value, which read as `neutral`
  };

  /* Reads all images of a file. Reads `count` channels, the first of which is `channel`: a name, a number from 0, or
   * empty for the first of the file. Texels without a value (NaN, -3.4e38, GDAL's nodata) and texels outside of an
   * image's data window read as `neutral`.
   * Throws Error as read() does, and if the file lacks the channels. Throws Canceled. */
  static FileInfo inspect(const std::string& path, const std::string& channel = "", int count = 1,
                          float neutral = 0.0f);

  /* Writes the heights as one float channel "Y", uncompressed; the file appears when it is complete. `recipe` describes
   * how the map was made and is stored in the header. Throws Error. */
  void write(const std::string& path, const std::string& recipe = "") const;

  /* Returns the recipe of a file, or an empty string if it has none or is not an image. */
  static std::string recipeOf(const std::string& path);

  int width() const { return w; }
  int height() const { return h; }
  float& at(int x, int y) { return texels[size_t(y) * w + x]; }
  float at(int x, int y) const { return texels[size_t(y) * w + x]; }

  /* Bilinear, in texels: (0,0) is the center of the first texel. Coordinates outside of the map are clamped. */
  float sampleTexels(float x, float y) const;

private:
  int w = 0, h = 0;
  std::vector<float> texels;
};

} // namespace cbvh
