// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Counts hits with a filter that rejects every hit: each crossing of the surface must be reported exactly once. */

#include "building/built_scene.h"
#include "tracing/ray.h"

#include <vector>

namespace programs {

struct CrossingCounts {
  size_t rays = 0;
  size_t sceneCrossings = 0, gridCrossings = 0;
  size_t differentCounts = 0;   // rays with another number of crossings than in GRID
  size_t differentParities = 0; // of these: rays that end on the other side of a closed surface
};

/* Both scenes must be built with BuildSettings::filters. Throws Canceled. */
CrossingCounts countCrossings(const BuiltScene& grid, const BuiltScene& scene, const std::vector<Ray>& rays,
                              unsigned threads);

} // namespace programs
