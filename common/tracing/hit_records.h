// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Hits as Embree reports them, to compare two libraries. */

#include "building/traced_scene.h"
#include "tracing/trace_timing.h"

#include <vector>

namespace programs {

struct HitRecord {
  bool hit = false; // the only valid member for misses and any-hit queries
  unsigned geometry = 0, primitive = 0, instance = 0;
  float t = 0, u = 0, v = 0;
  Vec3f normal;
};

/* Traces the rays once, otherwise as timeTrace. Not for Vulkan devices. Throws Canceled. */
std::vector<HitRecord> recordHits(const TracedScene& scene, const std::vector<Ray>& rays,
                                  const TraceSettings& settings);

/* Rays with different hits in two libraries, each counted under its first difference. */
struct HitDifferences {
  size_t rays = 0;
  size_t hits = 0; // only one library hits
  size_t ids = 0;  // geometry, primitive or instance
  size_t distances = 0;
  size_t surfaces = 0; // u, v or the normal

  size_t all() const { return hits + ids + distances + surfaces; }
};

/* Both arguments belong to the same rays. */
HitDifferences compareHitRecords(const std::vector<HitRecord>& a, const std::vector<HitRecord>& b);

} // namespace programs
