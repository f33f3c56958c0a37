// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The library against the scalar intersector in double, on the very blocks that the library
 * built: closest and any hit, parameters and normals.
 *
 * They must be equal but where rounding decides. The SIMD code knows a ray inside a block up
 * to the vector "epsilon" of framed/local_ray.h, at both ends of its segment, and widens bounds
 * by as much. So an answer that differs must be one that the scalar intersector finds for a ray
 * whose ends in the block are moved by no more than that, with bounds widened by 0 to 2
 * epsilons (once by SIMD itself, once as the moved ray's own error): a miss, or a hit in a leaf
 * with t, u, v and normal of that leaf. Such rays are counted by what rounding decides:
 *   - hit or miss, as at silhouettes and borders,
 *   - which of several leaves, as at edges and where leaves overlap,
 *   - where on one leaf, as for rays that graze it.
 * cVERT's triangles are met with the ray itself, in double; an answer that differs must be that
 * of a triangle whose edge, or whose plane, is within the ray's rounding.
 *
 * What t itself rounds comes on top: the sum t0 + tau (t1-t0) of a few rounded terms as large
 * as the distance to the block. */

#include "kernels/cbvh/framed/block.h"
#include "support/random_sheets.h"
#include "support/vert_triangles.h"

namespace cbvh::test {

class ReferenceCheck
{
public:
  // Closest hits of rays, and with their RTCRay alone whether they hit anything.
  using Trace = std::function<void(RTCScene, std::vector<RTCRayHit>& closest, std::vector<RTCRay>& any)>;

  // traceRays: what has to equal the reference, Embree's single rays by default.
  ReferenceCheck(RTCDevice device, RTCCompression compression, Trace traceRays = traceByEmbree)
    : device(device), compression(compression), traceRays(std::move(traceRays)) {}

  static void traceByEmbree(RTCScene scene, std::vector<RTCRayHit>& closest, std::vector<RTCRay>& any);

  // Random rays of the kinds at a sheet, with directions of length 1 or of every length
  // that Embree allows. A sheet that is not compressed has to have GRID's hits.
  void trace(Random& random, const Sheet& sheet, const std::vector<RayKind>& kinds, unsigned raysOfAKind, bool unitLength = true);

  // Fails if the rays said too little. share: of them that has to be equal in t, as
  // too many explanations would explain anything.
  void conclude(double share = 0.75);

  unsigned sheetsOfGrid = 0; // not compressed

private:
  // A ray, and what was found for it.
  struct Answer
  {
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
  unsigned sameT = 0;                                       // and hit or miss
  unsigned atBorder = 0, betweenLeaves = 0, alongLeaf = 0; // explained by rounding
  unsigned hitsOfGrid = 0, strayed = 0;                    // cGRID: as GRID's triangle test rounds
};

} // namespace cbvh::test
