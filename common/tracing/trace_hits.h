// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/traced_scene.h"
#include "tracing/ray_sets.h"

#include <vector>

namespace programs {

/* Traces n rays on the calling thread. */
void traceClosest(const TracedScene& scene, size_t n, const Ray* rays, SurfaceHit* hits);

/* Throws Canceled. */
std::vector<SurfaceHit> traceClosest(const TracedScene& scene, const std::vector<Ray>& rays, unsigned threads);

/* Number of rays whose any-hit query disagrees with `closest`. Throws Canceled. */
size_t countAnyHitDisagreements(const TracedScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& closest, unsigned threads);

} // namespace programs
