// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures/image.h"

#include <algorithm>
#include <cmath>

namespace programs {
namespace {

uint8_t encodeSrgb(float linear) {
  const float c = std::min(std::max(linear, 0.0f), 1.0f);
  const float s = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
  return uint8_t(s * 255.0f + 0.5f);
}

} // namespace

void Image::set(size_t pixel, Vec3f color) {
  rgb[3 * pixel + 0] = encodeSrgb(color.x);
  rgb[3 * pixel + 1] = encodeSrgb(color.y);
  rgb[3 * pixel + 2] = encodeSrgb(color.z);
}

} // namespace programs
