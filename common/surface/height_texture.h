// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height and vector maps through OpenImageIO's texture system, which loads tiles on demand and chooses mip levels by
 * filter width. */

#include "basics/vec.h"

#include <memory>
#include <string>
#include <vector>

namespace cbvh {

enum class TextureWrap { Repeat, Clamp };

/* The channels to read. */
struct TextureChannels
{
  std::string first; // name, or number from 0; empty: the first of the file
  int count = 1;     // 1 for heights, 3 for vectors
  float neutral = 0; // value of texels without a value
};

class HeightTexture
{
public:
  /* Opens files and reads each once, to check that all texels are finite.
   * `paths` names one file, all images of which are used, or several files, of which only the first images are used.
   * Appends a line to `warnings` for each file with texels without a value.
   * Throws Error, one line that starts with the path. Throws Canceled. */
  HeightTexture(const std::vector<std::string>& paths, const TextureChannels& channels, TextureWrap wrap,
                std::string& warnings);
  ~HeightTexture();
  HeightTexture(const HeightTexture&) = delete;
  HeightTexture& operator=(const HeightTexture&) = delete;

  /* Number of images: one per file, or one per face of a Ptex file or of a TIFF or EXR with several parts. */
  unsigned numImages() const { return images; }

  /* Returns the number of texels of an image along s and t; image < numImages(). */
  Vec2f size(unsigned image) const;

  /* True if the first image has the same value along its whole border. */
  bool hasConstantBorder() const { return constantBorder; }

  /* True if the colors of the first image are unit vectors, most of which point along blue. */
  bool looksLikeNormals() const;

  /* Writes the channels of an image at (s,t) to `values`: trilinear between mip levels, bicubic if texels are wider
   * than the filter. (0,0) is the upper left corner of the image, (1,1) the lower right. The filter widths are
   * fractions of the image; image < numImages(). A pure function of its arguments. Thread-safe. */
  void sample(unsigned image, float s, float t, float widthS, float widthT, float* values) const;

private:
  void fillCache() const;

  struct Implementation;
  std::unique_ptr<Implementation> implementation;
  unsigned images = 0;
  bool constantBorder = false;
};

} // namespace cbvh
