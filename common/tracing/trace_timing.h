// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/traced_scene.h"
#include "tracing/ray_sets.h"
#include "tracing/trace_modes.h"

#include <vector>

namespace programs {

struct TraceSettings {
  Query query = Closest;
  TraceMode mode = TraceMode::Single;
  bool coherent = false; // the flag that Embree receives
  unsigned threads = 1;  // 1: the calling thread
  unsigned passes = 1;   // over the rays, for short measurements
};

struct TraceTiming {
  /* Per pass, including filling Embree's ray structs but not starting threads. One thread: processor time, because
   * other programs disturb it less. Several: wall-clock time. Vulkan: the device's clock, without copies. */
  double seconds = 0;
  size_t hits = 0;
};

/* Ignores mode, coherence and threads for a Vulkan device. Throws Error. */
TraceTiming timeTrace(const TracedScene& scene, const std::vector<Ray>& rays, const TraceSettings& settings);

} // namespace programs
