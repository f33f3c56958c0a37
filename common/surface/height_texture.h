// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height maps through OpenImageIO's texture system: tiles as they are needed, a mip
 * level by the width asked for. */

#include <memory>
#include <string>

namespace cbvh {

enum class TextureWrap { Repeat, Clamp };

class HeightTexture
{
public:
  /* Opens an image and reads all of it once to see that it can be read and is finite.
   * Throws Error, one line that starts with the path. */
  HeightTexture(const std::string& path, TextureWrap wrap);
  ~HeightTexture();
  HeightTexture(const HeightTexture&) = delete;
  HeightTexture& operator=(const HeightTexture&) = delete;

  /* Images in the file: 1, or one a face in a Ptex file and in a TIFF or EXR of parts. */
  unsigned numImages() const { return images; }

  /* Whether the first image has one height all along its border. */
  bool hasConstantBorder() const { return constantBorder; }

  /* First channel, trilinear between mip levels, bicubic where texels are wider than
   * the width asked for. (0,0) is the upper left corner of the image, (1,1) the lower
   * right. A pure function of its arguments.
   * image: less than numImages(). widthS, widthT: of the filter, as a part of the map.
   * Thread safety: callable from any number of threads. */
  float sample(unsigned image, float s, float t, float widthS, float widthT) const;

private:
  void fillCache() const;

  struct Implementation;
  std::unique_ptr<Implementation> implementation;
  unsigned images;
  bool constantBorder;
};

} // namespace cbvh
