// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/aim_points.h"
#include "basics/sampling.h"

namespace programs {

/* Each point is on a row (or with probability 1/2 a column) of a random patch: the first, the last, a border of a
 * block, or any. */
AimPoints pickAimPoints(const BlockGrid& blocks, const std::vector<Vec3f>& vertices, size_t count, uint32_t seed) {
  const std::vector<Patch>& patches = blocks.layout.patches();
  const size_t block = blocks.blockWidth();
  std::mt19937 random(seed);
  AimPoints points;
  for (int kind = 0; kind < numAimKinds; kind++)
    for (size_t i = 0; i < count; i++) {
      const Patch& patch = patches[uniformIndex(patches.size(), random)];
      const size_t n = patch.resolution;
      const size_t corner[2] = {n * uniformIndex(2, random), n * uniformIndex(2, random)};
      size_t row = uniformIndex(n + 1, random), along = uniformIndex(n + 1, random);
      if (kind == AtCageVertex || kind == AtFaceBorder) row = corner[0];
      if (kind == AtCageVertex) along = corner[1];
      if (kind == AtBlockBorder) row = std::min(n, block * uniformIndex(n / block + 1, random));
      const bool swap = random() & 1;
      const auto at = [&](size_t r, size_t a) {
        return vertices[patch.firstVertex + (swap ? a * (n + 1) + r : r * (n + 1) + a)];
      };
      const size_t a0 = along > 0 ? along - 1 : along, a1 = along < n ? along + 1 : along;
      const size_t r0 = row > 0 ? row - 1 : row, r1 = row < n ? row + 1 : row;
      AimPoint point;
      point.position = at(row, along);
      point.neighbor = along == n || (along > 0 && (random() & 1)) ? at(row, a0) : at(row, a1);
      point.normal = cross(at(row, a1) - at(row, a0), at(r1, along) - at(r0, along));
      if (swap) point.normal = -point.normal;
      if (isFinite(point.position) && isFinite(point.neighbor) && hasDirection(point.normal))
        points[size_t(kind)].push_back(point);
    }
  return points;
}

} // namespace programs
