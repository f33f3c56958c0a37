// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/height_map.h"

#include <algorithm>

namespace programs {

float HeightMap::sampleTexels(float x, float y) const {
  x = std::min(std::max(x, 0.0f), float(w - 1));
  y = std::min(std::max(y, 0.0f), float(h - 1));
  const int x0 = int(x), y0 = int(y);
  const int x1 = std::min(x0 + 1, w - 1), y1 = std::min(y0 + 1, h - 1);
  const float fx = x - float(x0), fy = y - float(y0);
  const float top = at(x0, y0) * (1.0f - fx) + at(x1, y0) * fx;
  const float bottom = at(x0, y1) * (1.0f - fx) + at(x1, y1) * fx;
  return top * (1.0f - fy) + bottom * fy;
}

} // namespace programs
