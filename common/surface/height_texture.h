// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Maps of heights and of vectors through OpenImageIO's texture system: tiles as they are
 * needed, a mip level by the width asked for. */

#include "basics/vec.h"

#include <memory>
#include <string>
#include <vector>

namespace cbvh {

enum class TextureWrap { Repeat, Clamp };

/* What is read of files. */
struct TextureChannels
{
  std::string first; // name, or number from 0; empty for the first of the file
  int count = 1;     // 1 for heights, 3 for vectors
  float neutral = 0; // read for texels without a value
};

class HeightTexture
{
public:
  /* Opens files and reads all of them once to see that they can be read and are finite.
   * paths: one file, whose images are then those of the texture, or several of which the
   * first image counts. warnings: a line is added for each file with texels without a value.
   * Errors: throws Error, one line that starts with the path; Cancelled. */
  HeightTexture(const std::vector<std::string>& paths, const TextureChannels& channels, TextureWrap wrap,
                std::string& warnings);
  ~HeightTexture();
  HeightTexture(const HeightTexture&) = delete;
  HeightTexture& operator=(const HeightTexture&) = delete;

  /* One a file, or one a face in a Ptex file and in a TIFF or EXR of parts. */
  unsigned numImages() const { return images; }

  /* Texels of an image along s and t. image: less than numImages(). */
  Vec2f size(unsigned image) const;

  /* Whether the first image has one value all along its border. */
  bool hasConstantBorder() const { return constantBorder; }

  /* Whether the colours of the first image are unit vectors, most of them along blue. */
  bool looksLikeNormals() const;

  /* Trilinear between mip levels, bicubic where texels are wider than the width asked for.
   * (0,0) is the upper left corner of the image, (1,1) the lower right. A pure function of
   * its arguments.
   * image: less than numImages(). widthS, widthT: of the filter, as a part of the map.
   * values: as many as channels, written.
   * Thread safety: callable from any number of threads. */
  void sample(unsigned image, float s, float t, float widthS, float widthT, float* values) const;

private:
  void fillCache() const;

  struct Implementation;
  std::unique_ptr<Implementation> implementation;
  unsigned images = 0;
  bool constantBorder = false;
};

} // namespace cbvh
