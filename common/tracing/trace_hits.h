// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tracing ray sets for their hits. */

#include "building/traced_scene.h"
#include "tracing/ray_sets.h"

#include <vector>

namespace cbvh {

/* Closest hits of n rays, on the calling thread.
 *
 * rays, hits: n each; hits are written. */
void traceClosest(const TracedScene& scene, size_t n, const Ray* rays, SurfaceHit* hits);

/* Closest hits, one a ray. Throws Cancelled. */
std::vector<SurfaceHit> traceClosest(const TracedScene& scene, const std::vector<Ray>& rays, unsigned threads);

/* Number of rays for which any-hit and the given closest hits disagree on whether
 * something is hit. Throws Cancelled. */
size_t countAnyHitDisagreements(const TracedScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& closest, unsigned threads);

} // namespace cbvh
