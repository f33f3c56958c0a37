// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface/placed_map.h"

#include <memory>

namespace cbvh {

/* `map` has three channels; `description` holds scale, mid level and axes. Throws Error for tangent-space vectors
 * without texture coordinates. */
std::unique_ptr<Displacement> displaceByVectors(const Cage& cage, std::unique_ptr<PlacedMap> map,
                                                const DisplacementMap& description);

} // namespace cbvh
