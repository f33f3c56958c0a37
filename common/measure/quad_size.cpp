// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/quad_size.h"

#include <algorithm>
#include <cmath>

namespace programs {

float medianQuadSize(ImageSize size, const std::vector<SurfaceHit>& hits, int level) {
  constexpr size_t fewest = 16; // pixels
  std::vector<float> sizes;
  for (int y = 0; y + 1 < size.height; y++)
    for (int x = 0; x + 1 < size.width; x++) {
      const size_t pixel = size_t(y) * size_t(size.width) + size_t(x);
      const SurfaceHit &here = hits[pixel], &right = hits[pixel + 1], &below = hits[pixel + size_t(size.width)];
      if (!here.hit() || !right.hit() || !below.hit() || right.face != here.face || below.face != here.face) continue;
      const float area = std::abs((right.u - here.u) * (below.v - here.v) - (right.v - here.v) * (below.u - here.u));
      if (area > 0.0f) // of a pixel, in the face's coordinates
        sizes.push_back(std::ldexp(1.0f / std::sqrt(area), -level));
    }
  if (sizes.size() < fewest) return 0.0f;
  const auto middle = sizes.begin() + ptrdiff_t(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

} // namespace programs
