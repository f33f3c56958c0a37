// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Heights in the colors of map tiles, with 8 bits per channel.
 * Based on: Mapzen, "Terrain Tiles: Data formats", 2017; Mapbox, "Mapbox Terrain-RGB v1", 2016. */

#include <cmath>

namespace programs {

enum class HeightEncoding {
  Plain,     // a channel is the height
  Terrarium, // 256 R + G + B/256 - 32768
  Mapbox     // (65536 R + 256 G + B)/10 - 10000
};

/* color: red, green and blue in 0..1. NaN if a channel is NaN. */
inline float decodeHeight(HeightEncoding encoding, const float* color) {
  double bytes[3];
  for (int c = 0; c < 3; c++) bytes[c] = std::round(255.0 * double(color[c]));
  if (encoding == HeightEncoding::Terrarium) return float(256 * bytes[0] + bytes[1] + bytes[2] / 256 - 32768);
  return float((65536 * bytes[0] + 256 * bytes[1] + bytes[2]) / 10 - 10000);
}

} // namespace programs
