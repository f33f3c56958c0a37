// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compares closest hits and any hit with the scalar intersector in double precision on the same blocks.
 *
 * The results must be equal except for rounding. SIMD knows both ends of a ray in a block up to "epsilon" of
 * paper/local_ray.h, and widens bounds by as much. A different result must therefore be the scalar intersector's for a
 * ray whose ends move by at most 2 epsilons (one for the ray, one for heights of leaves), with bounds widened by 0 to 2
 * epsilons (one by SIMD, one for the moved ray):
 * a miss, or a hit with t, u, v and normal of its leaf. Such rays are counted by the decision that rounding affects:
 *   - hit or miss, for example at silhouettes and borders,
 *   - which of several leaves, for example at edges and where leaves overlap,
 *   - the position on one leaf, for rays that graze it.
 * Triangles of cVERT are intersected with the original ray in double precision. A different result must belong to a
 * triangle whose edge or plane is within the ray's rounding error.
 *
 * In addition, t itself rounds: t0 + tau (t1-t0) has a few terms as large as the distance to the block. */

#include "kernels/cbvh/paper/block.h"
#include "support/random_sheets.h"
#include "support/vert_triangles.h"

namespace programs::test {

class ReferenceCheck {
public:
  // Traces closest hits of rays, and any hit with only their RTCRay.
  using Trace = std::function<void(RTCScene, std::vector<RTCRayHit>& closest, std::vector<RTCRay>& any)>;

  // traceRays: the function under test; by default Embree's single rays.
  ReferenceCheck(RTCDevice device, RTCCompression compression, Trace traceRays = traceByEmbree)
    : device(device),
      compression(compression),
      traceRays(std::move(traceRays)) {}

  static void traceByEmbree(RTCScene scene, std::vector<RTCRayHit>& closest, std::vector<RTCRay>& any);

  // Directions have length 1, or lengths from 1e-15 to 1e18. A sheet that is not compressed must have GRID's hits.
  void trace(Random& random, const Sheet& sheet, const std::vector<RayKind>& kinds, unsigned raysPerKind,
             bool unitLength = true);

  // Fails if the rays were not conclusive. share: minimum share of rays with equal t, because a tolerance that
  // explains many differences would hide errors.
  void conclude(double share = 0.75);

  unsigned sheetsOfGrid = 0; // sheets that are not compressed

private:
  struct Answer {
    RTCRayHit ray, found, ofGrid;
    bool isOccluded, isOccludedInGrid;
    RayKind kind;
  };

  void compare(const Answer& answer, const Sheet& sheet, const embree::cbvh::Block* block);
  void compareTriangles(const Answer& answer, const Sheet& sheet, const std::vector<VertTriangle>& triangles);

  RTCDevice device;
  RTCCompression compression;
  Trace traceRays;
  unsigned rays = 0, hits = 0, equal = 0, failures = 0;
  unsigned sameT = 0;                                      // equal t, or both miss
  unsigned atBorder = 0, betweenLeaves = 0, alongLeaf = 0; // explained by rounding
  unsigned hitsOfGrid = 0, strayed = 0;                    // cGRID: as GRID's triangle test rounds
};

} // namespace programs::test
