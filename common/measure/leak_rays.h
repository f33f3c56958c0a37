// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays from the inside of a closed surface: each must hit it. Most aim at places where a ray could leak through,
 * directly or at grazing angles. */

#include "building/scene_tracer.h"
#include "measure/aim_points.h"
#include "tracing/ray.h"

#include <embree3/rtcore.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace programs {

struct LeakSettings {
  size_t rays = 1000000;  // approximate
  float thickness = 0.0f; // maximum over the scene, world units
  uint32_t seed = 1;
};

/* `through` counts rays that pass the wall in front of them by more than twice the thickness, and hit another wall from
 * outside. */
struct Leaks {
  size_t closest = 0; // closest-hit queries that miss
  size_t any = 0;     // any-hit queries that miss
  size_t through = 0;

  Leaks& operator+=(const Leaks& other);
};

struct LeakCounts {
  size_t rays = 0;
  size_t aimed = 0; // rays at aim points and edges
  Leaks sceneLeaks, gridLeaks;
  Leaks random; // the part of sceneLeaks that is not aimed
  static constexpr size_t maxExamples = 16;
  std::vector<Ray> examples; // leaks in the scene
};

/* Traces rays through a scene and through GRID of the same surface, with `points` on it. Returns no rays if no place
 * is inside, as for open surfaces. Throws Canceled. */
LeakCounts countLeaks(RTCScene grid, const SceneTracer& scene, const AimPoints& points, const LeakSettings& settings,
                      unsigned threads);

} // namespace programs
