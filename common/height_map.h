// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height maps: one float a texel, read by OpenImageIO (float EXR, 16-bit PNG or
 * TIFF, anything else it knows; integers become 0..1). Row 0 is the top of the
 * image. */

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

  /* Writes one float channel "Y", uncompressed, under a temporary name that is
   * renamed at the end. Throws Error. */
  void write(const std::string& path) const;

  int width() const { return w; }
  int height() const { return h; }
  float& at(int x, int y) { return texels[size_t(y) * w + x]; }
  float at(int x, int y) const { return texels[size_t(y) * w + x]; }

  /* Bilinear, in texels: (0,0) is the centre of the first. Beyond the edge the
   * border is repeated. */
  float sampleTexels(float x, float y) const;

  /* Bilinear at texture coordinates as OBJ has them: (0,0) the lower left corner
   * of the image, (1,1) the upper right, repeated outside. */
  float sampleRepeated(float s, float t) const;

  /* Whether the border texels all have the same height, so that copies of the map
   * side by side do not tear. */
  bool hasConstantBorder() const;

private:
  int w = 0, h = 0;
  std::vector<float> texels;
};

} // namespace cbvh
