// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Points of a tessellation at which a ray could leak through. */

#include "measure/block_grid.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace programs {

/* A vertex of GRID, to the bit. */
struct AimPoint {
  Vec3f position;
  Vec3f neighbor; // the other end of a quad's edge
  Vec3f normal;   // outwards, approximate
};

enum AimKind { AtCageVertex, AtFaceBorder, AtBlockBorder, AtVertex, numAimKinds };

using AimPoints = std::array<std::vector<AimPoint>, numAimKinds>;

/* Picks at most `count` points of each kind. `vertices` come from tessellate(). */
AimPoints pickAimPoints(const BlockGrid& blocks, const std::vector<Vec3f>& vertices, size_t count, uint32_t seed);

} // namespace programs
