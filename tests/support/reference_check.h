// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The library against the scalar reference, on the very blocks that the library built:
 * closest and any hit.
 *
 * The bound. The SIMD code knows a ray inside a block up to the vector "epsilon" of
 * local_ray.h, at both ends of its segment, and widens bounds by as much. So its hit
 * must be one that the reference finds for a ray whose ends in the block are moved by
 * no more than that:
 *   - it may not be nearer than the nearest hit of any such ray with bounds widened by
 *     0 to 2 epsilons (once by SIMD itself, once as the moved ray's own error),
 *   - it may not be farther than the farthest of them,
 *   - it may be missing only if one of them misses without widening.
 * What t itself rounds comes on top: the sum t0 + tau (t1-t0) of a few rounded terms
 * as large as the distance to the block. */

#include "kernels/cbvh/codec/block.h"
#include "support/random_sheets.h"

namespace cbvh::test {

class ReferenceCheck
{
public:
  ReferenceCheck(RTCDevice device, RTCCompression compression) : device(device), compression(compression) {}

  // Random rays of the kinds at a sheet, with directions of length 1 or of every length
  // that Embree allows. A sheet that is not compressed has to have GRID's hits.
  void trace(Random& random, const Sheet& sheet, const std::vector<RayKind>& kinds, unsigned raysOfAKind, bool unitLength = true);

  // Fails if the rays said too little. exact: part of them that has to have the
  // reference's own hit, not just one of the moved rays.
  void conclude(double exact = 0.75);

  unsigned sheetsOfGrid = 0; // not compressed

private:
  void compare(const RTCRayHit& ray, RayKind kind, const Sheet& sheet, const embree::cbvh::Block* block, RTCScene scene, RTCScene grid);

  RTCDevice device;
  RTCCompression compression;
  unsigned rays = 0, hits = 0, exactRays = 0, hitsOfGrid = 0, strayed = 0, parameters = 0, failures = 0;
};

} // namespace cbvh::test
