// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What Embree says of every ray, kept as it is: whether two builds of it say the same can be
 * seen to the last bit. */

#include "building/traced_scene.h"
#include "tracing/trace_timing.h"

#include <vector>

namespace cbvh {

struct KeptHit
{
  bool hit = false; // all there is of a miss, and of a query for any hit
  unsigned geometry = 0, primitive = 0, instance = 0;
  float t = 0, u = 0, v = 0;
  Vec3f normal;
};

/* Traces the rays as timeTrace does with the same settings, but once; not for a Vulkan device.
 * Throws Cancelled. */
std::vector<KeptHit> keepHits(const TracedScene& scene, const std::vector<Ray>& rays, const TraceSettings& settings);

/* Rays that two libraries see differently, each counted by the first thing that differs. */
struct HitDifferences
{
  size_t rays = 0;     // compared
  size_t hits = 0;     // one says hit and the other miss
  size_t ids = 0;      // of geometry, primitive or instance
  size_t distances = 0;
  size_t surfaces = 0; // u, v or the normal

  size_t all() const { return hits + ids + distances + surfaces; }
};

/* a, b: of the same rays. */
HitDifferences compareKept(const std::vector<KeptHit>& a, const std::vector<KeptHit>& b);

} // namespace cbvh
