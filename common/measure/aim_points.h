// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Points of a tessellation at which a ray could slip through. */

#include "measure/block_grid.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cbvh {

/* A vertex of the tessellation, to the last bit. */
struct AimPoint
{
  Vec3f position;
  Vec3f neighbour; // the other end of an edge of a quad
  Vec3f normal;    // outwards, roughly
};

/* What meets there. */
enum Meeting { AtCageVertex, AtFaceBorder, AtBlockBorder, AtVertex, numMeetings };

using AimPoints = std::array<std::vector<AimPoint>, numMeetings>;

/* Picks about count points of each kind.
 *
 * vertices: as tessellate makes them. */
AimPoints pickAimPoints(const BlockGrid& blocks, const std::vector<Vec3f>& vertices, size_t count, uint32_t seed);

} // namespace cbvh
