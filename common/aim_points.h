// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a tessellation, by what meets there: where a ray could slip through. */

#include "built_scene.h"

#include <array>
#include <vector>

namespace cbvh {

/* On the surface to the last bit, all of them. */
struct AimPoint
{
  Vec3f position;
  Vec3f neighbour; // the other end of an edge of a quad, along the border for a border
  Vec3f normal;    // outwards, roughly
};

enum Meeting { AtCageVertex, AtFaceBorder, AtBlockBorder, AtVertex, numMeetings };

using AimPoints = std::array<std::vector<AimPoint>, numMeetings>;

/* Picks about count points of each kind.
 *
 * vertices: as tessellate makes them. frameLevel: of the blocks. */
AimPoints pickAimPoints(const PatchLayout& layout, const std::vector<Vec3f>& vertices, int level, int frameLevel,
                        size_t count, uint32_t seed);

} // namespace cbvh
