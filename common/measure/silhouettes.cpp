// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/silhouettes.h"

#include <cmath>

namespace programs {

std::vector<size_t> hitsAwayFromSilhouettes(const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits,
                                            const Camera& camera) {
  constexpr float tolerance = 3.0f; // pixels
  const int width = camera.size().width, height = camera.size().height;
  const auto index = [&](int x, int y) { return size_t(y) * size_t(width) + size_t(x); };
  const auto seesPlane = [&](size_t middle, size_t other) {
    if (!hits[other].hit()) return false;
    const Vec3f d = primary[middle].direction, n = hits[middle].normal;
    const float t = hits[middle].t * dot(d, n) / dot(primary[other].direction, n);
    return std::abs(t - hits[other].t) <= tolerance * camera.footprint() * hits[middle].t; // false for NaN
  };

  std::vector<size_t> found;
  for (int y = 1; y + 1 < height; y++)
    for (int x = 1; x + 1 < width; x++) {
      bool all = hits[index(x, y)].hit();
      for (int k = 0; all && k < 9; k++) all = seesPlane(index(x, y), index(x + k % 3 - 1, y + k / 3 - 1));
      if (all) found.push_back(index(x, y));
    }
  return found;
}

} // namespace programs
