// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tracing ray sets for the clock, through every entrance of Embree's API. */

#include "building/traced_scene.h"
#include "tracing/ray_sets.h"
#include "tracing/trace_modes.h"

#include <vector>

namespace cbvh {

struct TraceSettings
{
  Query query = Closest;
  TraceMode mode = TraceMode::Single;
  bool coherent = false; // the flag that Embree gets with the rays
  unsigned threads = 1;  // 1: the calling thread
  unsigned passes = 1;   // over the rays, for sets that one pass is too short to time
};

struct TraceTiming
{
  /* Of one pass, filling Embree's ray structures included, starting threads not. One
   * thread is timed by its processor time, which other programs disturb less, several
   * by the wall clock. Of a Vulkan device: by its own clock, copies left out. */
  double seconds = 0;
  size_t hits = 0; // rays that hit something
};

/* Traces all rays; mode, coherence and threads are without meaning for a Vulkan device. Throws Cancelled. */
TraceTiming timeTrace(const TracedScene& scene, const std::vector<Ray>& rays, const TraceSettings& settings);

} // namespace cbvh
