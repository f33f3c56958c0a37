// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compares a compressed surface with GRID's surface of the same cage. cGRID finds GRID's hits to within a few ulps.
 * cVOXEL and cLEAF are approximate:
 *
 *   - Their hits lie in the box of the leaf that reports them. The box contains the leaf's quad, so GRID's surface is
 *     no farther than the farthest corner of the box.
 *   - They hit if GRID hits. cVOXEL always does because boxes contain the surface. cLEAF may miss grazing rays: its
 *     patches bound the vertices of a quad, but a triangle between them may cross a patch.
 *   - Across the surface they differ by at most the thickness in the statistics, except for hits on the extrapolated
 *     surface of a leaf beyond its quad. */

#include "support/random.h"
#include "support/scene.h"

namespace cbvh::test {

void expectEqualToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage);

// Checks all of these properties. settings: those of the scene's surface, with a displacement.
void expectCloseToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage,
                       const SurfaceSettings& settings);

// Checks any surface: every hit lies in the box of the leaf with its parameters, GRID's surface is no farther than
// the farthest corner of that box, and closest hit and any hit agree. slack: additional distance for different
// tessellations.
void expectHitsNearGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, float slack = 0);

// Checks that rays from inside a closed surface hit it. cGRID may miss if GRID misses, because both intersect the
// same triangles.
void expectNoLeaks(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& raysFromInside,
                   RTCCompression compression);

} // namespace cbvh::test
