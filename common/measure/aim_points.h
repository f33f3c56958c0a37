// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Aim points of a model. */

#include "measure/leak_rays.h"
#include "surface/cage.h"

#include <vector>

namespace cbvh {

/* Picks about count points of each kind.
 *
 * vertices: as tessellate makes them. frameLevel: of the blocks. */
AimPoints pickAimPoints(const PatchLayout& layout, const std::vector<Vec3f>& vertices, int level, int frameLevel,
                        size_t count, uint32_t seed);

} // namespace cbvh
