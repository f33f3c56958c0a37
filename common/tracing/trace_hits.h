// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/traced_scene.h"
#include "tracing/ray_sets.h"

#include <vector>

namespace programs {

/* Trace n rays on the calling thread. traceAny sets hits[i] to 1 if ray i hits anything, otherwise to 0. */
void traceClosest(const TracedScene& scene, size_t n, const Ray* rays, SurfaceHit* hits);
void traceAny(const TracedScene& scene, size_t n, const Ray* rays, char* hits);

/* Throws Canceled. */
std::vector<SurfaceHit> traceClosest(const TracedScene& scene, const std::vector<Ray>& rays, unsigned threads);

/* Number of rays whose any-hit query disagrees with `closest`. Throws Canceled. */
size_t countAnyHitDisagreements(const TracedScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& closest, unsigned threads);

} // namespace programs
