// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tracing ray sets for their hits. */

#include "building/built_scene.h"
#include "tracing/ray_sets.h"

#include <vector>

namespace cbvh {

class SavedScene;

/* Closest hits of n rays, on the calling thread.
 *
 * rays, hits: n each; hits are written. */
void traceClosest(const BuiltScene& scene, size_t n, const Ray* rays, SurfaceHit* hits);

/* Closest hits, one a ray. Throws Cancelled. */
std::vector<SurfaceHit> traceClosest(const BuiltScene& scene, const std::vector<Ray>& rays, unsigned threads);

/* The same of a scene from a file. */
std::vector<SurfaceHit> traceClosest(const SavedScene& scene, const std::vector<Ray>& rays, unsigned threads);

/* Number of rays for which any-hit and the given closest hits disagree on whether
 * something is hit. Throws Cancelled. */
size_t countAnyHitDisagreements(const BuiltScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& closest, unsigned threads);

} // namespace cbvh
