// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measures the speed of tracing ray sets with every query of Embree's API. */

#include "building/traced_scene.h"
#include "tracing/ray_sets.h"
#include "tracing/trace_modes.h"

#include <vector>

namespace cbvh {

struct TraceSettings
{
  Query query = Closest;
  TraceMode mode = TraceMode::Single;
  bool coherent = false; // the flag that Embree receives with the rays
  unsigned threads = 1;  // 1: only the calling thread
  unsigned passes = 1;   // over the rays, if one pass is too short to measure
};

struct TraceTiming
{
  /* Seconds per pass, including filling Embree's ray structs but not starting threads. Processor time for one thread,
   * because other programs disturb it less; wall-clock time for several threads. On a Vulkan device: time of the
   * device's clock, without copies. */
  double seconds = 0;
  size_t hits = 0; // rays that hit something
};

/* Traces all rays. Ignores mode, coherence and threads for a Vulkan device. Throws Error. */
TraceTiming timeTrace(const TracedScene& scene, const std::vector<Ray>& rays, const TraceSettings& settings);

} // namespace cbvh
