// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A compressed surface against GRID's of the same cage. cGRID finds GRID's hits to a few
 * ulps. cVOXEL and cLEAF are approximate:
 *
 *   - where they hit, the place is in the box of the leaf that reports it, which contains its
 *     quad: GRID's surface is no farther than the box's farthest corner;
 *   - where GRID hits, so do they: cVOXEL always, as boxes contain the surface, cLEAF
 *     unless the ray grazes, as its patches bound the vertices of a quad, which a
 *     triangle between them may leave;
 *   - across the surface they differ by the thickness that the statistics report,
 *     but for hits on what a leaf extrapolates past its quad. */

#include "support/random.h"
#include "support/scene.h"

namespace cbvh::test {

void expectEqualToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage);

// All of the above; settings: those of the scene's surface, with a displacement.
void expectCloseToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage,
                       const SurfaceSettings& settings);

// Whatever the surface: every hit lies in the box of the leaf whose parameters it has, GRID's
// surface is no farther from it than that box's farthest corner, and closest and any hit agree.
// slack: for tessellations that differ.
void expectHitsNearGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, float slack = 0);

// Rays that start inside a closed surface hit it. Where GRID's triangles let a ray
// through, cGRID, which has the same, may.
void expectNoLeaks(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& raysFromInside, RTCCompression compression);

} // namespace cbvh::test
