// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Displacement by maps of vectors, along the axes of the cage or of its texture. */

#include "surface/placed_map.h"

#include <memory>

namespace cbvh {

/* The map must have three channels; `description` holds scale, mid level and axes. Throws Error for vectors in tangent
 * space on a cage without texture coordinates. */
std::unique_ptr<Displacement> displaceByVectors(const Cage& cage, std::unique_ptr<PlacedMap> map,
                                                const DisplacementMap& description);

} // namespace cbvh
