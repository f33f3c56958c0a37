// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays from inside of a closed surface, each of which has to hit it. Most aim where a
 * ray could slip through, straight on or so that they graze the surface there. */

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
  size_t rays = 1000000;   // about
  float thickness = 0.0f;  // of the surface in the scene, its largest; world units
  uint32_t seed = 1;
};

/* Of one scene. A ray leaks through when it does not see the wall in front of it, by
 * more than the thickness, and hits the outside of another. */
struct Leaks
{
  size_t closest = 0; // nothing hit
  size_t any = 0;     // nothing hit, any hit
  size_t through = 0;

  Leaks& operator+=(const Leaks& other);
};

struct LeakCounts
{
  size_t rays = 0;
  size_t aimed = 0;   // at aim points and edges
  Leaks ofScene, ofGrid;
  Leaks random;       // of the scene's, those of rays that are not aimed
  std::vector<Ray> examples; // of rays that leak in the scene, at most 16
};

/* grid: the same surface, by GRID. points: on it. No rays where no inside is found, as of
 * an open surface. Throws Cancelled. */
LeakCounts countLeaks(RTCScene grid, const SceneTracer& scene, const AimPoints& points, const LeakSettings& settings,
                      unsigned threads);

} // namespace cbvh
