// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "tracing/crop.h"
#include "tracing/ray.h"

#include <cstdint>
#include <vector>

namespace programs {

struct Shutter {
  float begin = 0, end = 1; // 0 is the model's first time step, 1 the last
};

/* Sets the time of this sample of each pixel. A pixel's times are spread evenly over the shutter; neighboring pixels
 * differ. `rays` holds one ray per pixel of a part of a picture that is `width` pixels wide. */
inline void setTimes(std::vector<Ray>& rays, const Shutter& shutter, int sample, const Crop& part, int width) {
  for (size_t i = 0; i < rays.size(); i++) {
    uint32_t h = (uint32_t(part.row(i)) * uint32_t(width) + uint32_t(part.column(i))) * 0x9E3779B1u;
    h = (h ^ (h >> 15)) * 0x85EBCA77u;
    h = (h ^ (h >> 13)) * 0xC2B2AE3Du;
    const uint32_t place = (h ^ (h >> 16)) + uint32_t(sample) * 0x9E3779B9u; // golden ratio
    rays[i].time = shutter.begin + (shutter.end - shutter.begin) * float(place >> 8) * 0x1p-24f;
  }
}

} // namespace programs
