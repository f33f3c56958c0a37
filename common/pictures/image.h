// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/vec.h"
#include "tracing/image_size.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace programs {

/* 8-bit sRGB, rows from the top. */
struct Image {
  explicit Image(ImageSize size) : size(size), rgb(size_t(size.width) * size.height * 3) {}

  /* `color` is linear and clamped to [0,1]. */
  void set(size_t pixel, Vec3f color);

  ImageSize size;
  std::vector<uint8_t> rgb;
};

} // namespace programs
