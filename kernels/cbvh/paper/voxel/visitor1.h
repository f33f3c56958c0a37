// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Visitor of block_walk1.h for leaves of cVOXEL. */

#include "../block_visitor1.h"

namespace embree::isa::cbvh {
/*! Rays hit a leaf where they enter its box, but not if they start inside: then they come from its surface, or
 *  are past it. */
template<typename RayType>
struct VoxelVisitor1 : public BlockVisitor1<RayType> {
  static const uint32_t kind = kindVoxel;
  using BlockVisitor1<RayType>::BlockVisitor1;

  __forceinline bool leaf(const NodeEntries::Tile& tile, uint32_t m, uint32_t grandchild, const BoxRanges<16>& ranges) {
    if (this->startsInside(ranges, grandchild)) return false;
    const float s = max(ranges.sNear[grandchild], 0.0f);
    // of this block's hits at the same distance, the first is accepted; reportHit() compares other blocks' hits
    if (this->isHit ? !(s < this->sBest) : s > this->sBest) return false;
    const float u = position(tile.grandchildren, 0, grandchild, s), v = position(tile.grandchildren, 1, grandchild, s);
    return this->reportHit(16 * m + grandchild, LeafHit1{s, u, v, 0.0f, 0.0f, false, false}) &&
           IsAnyHit<RayType>::value;
  }

private:
  /*! Position in a leaf's box at s along an axis: 0 at the lower plane, 1 at the upper one, clamped. */
  __forceinline float position(const NodePlanes<16>& boxes, int axis, uint32_t leaf, float s) const {
    const float lower = boxes.planes[axis][0][leaf], upper = boxes.planes[axis][1][leaf];
    return clamp((fused(s, this->nodeRay.D[axis], this->nodeRay.P[axis]) - lower) / (upper - lower), 0.0f, 1.0f);
  }
};
} // namespace embree::isa::cbvh
