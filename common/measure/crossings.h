// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a filter sees that rejects every hit, as renderers of transparent surfaces have one: each
 * place where a ray crosses the surface once, or not. */

#include "building/built_scene.h"
#include "tracing/ray.h"

#include <vector>

namespace cbvh {

struct CrossingCounts
{
  size_t rays = 0;
  size_t ofScene = 0, ofGrid = 0; // crossings
  size_t otherNumber = 0;         // rays that cross another number of times than GRID's
  size_t otherParity = 0;         // and those that end on the other side of a closed surface
};

/* Crossings of rays with a scene, beside GRID's. Both were built with BuildSettings::filters. Throws Cancelled. */
CrossingCounts countCrossings(const BuiltScene& grid, const BuiltScene& scene, const std::vector<Ray>& rays,
                              unsigned threads);

} // namespace cbvh
