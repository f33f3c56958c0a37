// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Traces ray sets for their hits. */

#include "building/traced_scene.h"
#include "tracing/ray_sets.h"

#include <vector>

namespace cbvh {

/* Writes the closest hits of n rays to hits[0] to hits[n-1]. Runs on the calling thread. */
void traceClosest(const TracedScene& scene, size_t n, const Ray* rays, SurfaceHit* hits);

/* Returns the closest hit of each ray. Throws Canceled. */
std::vector<SurfaceHit> traceClosest(const TracedScene& scene, const std::vector<Ray>& rays, unsigned threads);

/* Returns the number of rays for which an any-hit query and the given closest hits disagree. Throws Canceled. */
size_t countAnyHitDisagreements(const TracedScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& closest, unsigned threads);

} // namespace cbvh
