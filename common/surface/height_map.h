// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height maps: one float a texel, read by OpenImageIO (float EXR, 16-bit PNG or
 * TIFF, anything else it knows; integers become 0..1). Row 0 is the top of the
 * image. */

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
   * that are not finite. */
  static HeightMap read(const std::string& path);

  /* What is in a file, all images of which were read and found well. Throws Error as
   * read does. */
  struct FileInfo
  {
    unsigned images = 0;         // one a face in Ptex files; pages of a TIFF, parts of an EXR
    bool constantBorder = false; // of the first
  };
  static FileInfo inspect(const std::string& path);

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

  /* Whether the border texels all have the same height, so that copies of the map
   * side by side do not tear. */
  bool hasConstantBorder() const;

private:
  int w = 0, h = 0;
  std::vector<float> texels;
};

} // namespace cbvh
