// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* OpenImageIO's texture system, which loads tiles on demand and chooses mip levels by filter width. */

#include "basics/vec.h"
#include "surface/texture_wrap.h"

#include <memory>
#include <string>
#include <vector>

namespace programs {

struct TextureChannels {
  std::string first; // name, or number from 0; empty: the file's first
  int count = 1;     // 1 for heights, 3 for vectors
  float neutral = 0; // for texels without a value
};

class HeightTexture {
public:
  /* Opens files and checks that all texels are readable and finite. Uses all images of a single file, or the first
   * image of each of several files. Appends a line to `warnings` for each file with texels without a value. Throws
   * Error with the path. */
  HeightTexture(const std::vector<std::string>& paths, const TextureChannels& channels, TextureWrap wrap,
                std::string& warnings);
  ~HeightTexture();
  HeightTexture(const HeightTexture&) = delete;
  HeightTexture& operator=(const HeightTexture&) = delete;

  /* One per file, or per part of a Ptex, TIFF or EXR file. */
  unsigned numImages() const { return images; }

  /* Texels along s and t. */
  Vec2f size(unsigned image) const { return sizes[image]; }

  int numChannels() const { return channels; }

  /* Writes the channels of `count` texels of a row to `values`. Columns and rows outside of the image are wrapped.
   * Thread-safe. Throws Error. */
  void texels(unsigned image, int column, int row, int count, float* values) const;

  /* True if the first image has one value along its border. */
  bool hasConstantBorder() const { return constantBorder; }

  /* True if the first image's colors are unit vectors, mostly along blue. */
  bool looksLikeNormals() const;

  /* Writes the channels at (s,t) to `values`: trilinear between mip levels, bilinear if texels are wider than the
   * filter. (0,0) is the image's upper left corner, (1,1) the lower right; widths are fractions of the image. A pure
   * function while the files do not change; NaN if they became unreadable. Thread-safe. */
  void sample(unsigned image, float s, float t, float widthS, float widthT, float* values) const;

private:
  void fillCache() const;

  struct Implementation;
  std::unique_ptr<Implementation> implementation;
  unsigned images = 0;
  std::vector<Vec2f> sizes; // per image
  int channels = 1;
  TextureWrap wrap;
  bool constantBorder = false;
};

} // namespace programs
