// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Apart from trace_hits.cpp, as saved_scene.cpp says. */

#include "building/saved_scene.h"
#include "tracing/closest_hits.h"
#include "tracing/trace_hits.h"

namespace cbvh {

std::vector<SurfaceHit> traceClosest(const SavedScene& scene, const std::vector<Ray>& rays, unsigned threads)
{
  return closestHits(scene, EmbreeTracer(scene.handle()), rays, raysAtOnce, threads);
}

} // namespace cbvh
