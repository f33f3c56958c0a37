// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays from inside of a closed surface, each of which must hit it. Most aim at places where a ray could leak through,
 * either directly or at grazing angles. */

#include "building/scene_tracer.h"
#include "measure/aim_points.h"
#include "tracing/ray.h"

#include <embree3/rtcore.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cbvh {

struct LeakSettings
{
  size_t rays = 1000000;  // approximate number
  float thickness = 0.0f; // largest thickness of the surface in the scene, world units
  uint32_t seed = 1;
};

/* Leaks of one scene. A ray leaks through if it misses the wall in front of it, by more than the thickness, and hits
 * another wall from outside. */
struct Leaks
{
  size_t closest = 0; // closest-hit queries without a hit
  size_t any = 0;     // any-hit queries without a hit
  size_t through = 0;

  Leaks& operator+=(const Leaks& other);
};

struct LeakCounts
{
  size_t rays = 0;
  size_t aimed = 0; // rays at aim points and edges
  Leaks sceneLeaks, gridLeaks;
  Leaks random;     // part of sceneLeaks: rays that are not aimed
  std::vector<Ray> examples; // rays that leak in the scene, at most 16
};

/* Traces rays through a scene and through GRID of the same surface. `points` are on the surface. Returns no rays if no
 * place inside is found, as for open surfaces. Throws Cancelled. */
LeakCounts countLeaks(RTCScene grid, const SceneTracer& scene, const AimPoints& points, const LeakSettings& settings,
                      unsigned threads);

} // namespace cbvh
