// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tracing ray sets: once for the hits, on several threads, and for the clock, on
 * one thread with single rays. */

#include "built_scene.h"
#include "ray_sets.h"

#include <vector>

namespace cbvh {

/* Closest hits, one a ray. Throws Cancelled. */
std::vector<SurfaceHit> traceClosest(const BuiltScene& scene, const std::vector<Ray>& rays, unsigned threads);

/* Number of rays for which any-hit and the given closest hits disagree on whether
 * something is hit. Throws Cancelled. */
size_t countAnyHitDisagreements(const BuiltScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& closest, unsigned threads);

/* Seconds that the calling thread takes for all rays with rtcIntersect1 or
 * rtcOccluded1. Throws Cancelled. */
double timeClosest(const BuiltScene& scene, const std::vector<Ray>& rays);
double timeAny(const BuiltScene& scene, const std::vector<Ray>& rays);

} // namespace cbvh
