// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height maps: one float a texel, read by OpenImageIO (float EXR, 16-bit PNG or
 * TIFF, anything else it knows; unsigned integers become 0..1, signed integers -1..1; where
 * there is alpha, colours are not multiplied by it). So an int16 file of elevations in metres needs
 * a mid level of 0 and a scale of 32767 metres. Row 0 is the top of the image. */

#include <cstddef>
#include <string>
#include <vector>

namespace cbvh {

class HeightMap
{
public:
  HeightMap() = default;
  HeightMap(int width, int height) : w(width), h(height), texels(size_t(width) * height) {}

  /* Reads the first channel of an image. Throws Error, one line that starts with
   * the path, for a file that is missing, unreadable or truncated, and for texels
   * that are not finite or missing. */
  static HeightMap read(const std::string& path);

  /* What is in a file, all images of which were read and found well. */
  struct FileInfo
  {
    unsigned images = 0;         // one a face in Ptex files; pages of a TIFF, parts of an EXR
    std::vector<int> numbers;    // of the images within the file: a TIFF also has smaller copies and masks
    int firstChannel = 0;        // of those asked for
    int channels = 0;            // that the first image has
    bool constantBorder = false; // of the first
    bool isPlain = true;         // the texture system reads the same texels from the file, see map_image.h
    size_t missing = 0;          // texels without a value, which read as neutral
  };

  /* channel: the first one that is looked at, by its name or its number from 0; empty for
   * the first of the file. count: of channels from there on. neutral: read for texels without
   * a value (NaN, -3.4e38, GDAL's nodata) and outside of an image's data window.
   * Errors: throws Error as read does, and for channels that the file does not have;
   * Cancelled. */
  static FileInfo inspect(const std::string& path, const std::string& channel = "", int count = 1,
                          float neutral = 0.0f);

  /* Writes one float channel "Y", uncompressed, under a temporary name that is
   * renamed at the end. recipe: kept in the header, says how the map was made.
   * Throws Error. */
  void write(const std::string& path, const std::string& recipe = "") const;

  /* The recipe of a file, empty when it has none or is no image. */
  static std::string recipeOf(const std::string& path);

  int width() const { return w; }
  int height() const { return h; }
  float& at(int x, int y) { return texels[size_t(y) * w + x]; }
  float at(int x, int y) const { return texels[size_t(y) * w + x]; }

  /* Bilinear, in texels: (0,0) is the centre of the first. Beyond the edge the
   * border is repeated. */
  float sampleTexels(float x, float y) const;

private:
  int w = 0, h = 0;
  std::vector<float> texels;
};

} // namespace cbvh
