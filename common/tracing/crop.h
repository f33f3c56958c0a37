// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "tracing/image_size.h"

#include <cstddef>

namespace programs {

/* Part of a picture: columns x0 to x1 - 1 and rows y0 to y1 - 1; (0,0) is the upper left pixel. */
struct Crop {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  Crop() = default;
  Crop(int x0, int y0, int x1, int y1) : x0(x0), y0(y0), x1(x1), y1(y1) {}
  Crop(ImageSize whole) : x1(whole.width), y1(whole.height) {}

  ImageSize size() const { return {x1 - x0, y1 - y0}; }
  size_t numPixels() const { return size_t(x1 - x0) * size_t(y1 - y0); }
  int column(size_t pixel) const { return x0 + int(pixel % size_t(x1 - x0)); } // in the whole picture
  int row(size_t pixel) const { return y0 + int(pixel / size_t(x1 - x0)); }
};

} // namespace programs
