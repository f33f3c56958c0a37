// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compares a compressed surface with GRID's. cGRID finds GRID's hits to within a few ulps, cVERT to within the movement
 * of vertices in the statistics. cVOXEL and cLEAF are approximate:
 *
 *   - Hits lie in the box of their leaf, which contains the leaf's quad. So GRID's surface is no farther than the box's
 *     farthest corner.
 *   - They hit if GRID hits; only cLEAF may miss grazing rays, because its patches bound vertices, but not the
 *     triangles between them.
 *   - Across the surface they differ by at most the thickness in the statistics, except for hits on the extrapolated
 *     surface of a leaf beyond its quad. */

#include "support/random.h"
#include "support/scene.h"

namespace programs::test {

void expectEqualToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage);

// Checks all of these; few rays may be exceptions. settings: of the scene's surface, with a displacement.
void expectCloseToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage,
                       const SurfaceSettings& settings);

// The first property, for any surface, and that closest hit and any hit agree. slack: additional distance for different
// tessellations.
void expectHitsNearGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, float slack = 0);

// Rays from inside a closed surface must hit it. cGRID may miss if GRID does, because both intersect the same
// triangles.
void expectNoLeaks(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& raysFromInside,
                   RTCCompression compression);

} // namespace programs::test
