// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Visitor of block_walkK.h for leaves of cVOXEL: visitor1.h for packets. */

#include "../block_visitorK.h"

namespace embree::isa::cbvh {
template<int K, typename Rays>
struct VoxelVisitorK : public BlockVisitorK<K, Rays> {
  static const uint32_t kind = kindVoxel;
  using BlockVisitorK<K, Rays>::BlockVisitorK;

  __forceinline void leaf(const NodeEntries::Tile& tile, uint32_t m, uint32_t grandchild, const BoxRangesK<K>& box,
                          const vbool<K>& lanes) {
    LeafHits<K> hits;
    hits.s = max(box.sNear, vfloat<K>(zero));
    // as in visitor1.h
    const vbool<K> nearer = (hits.s < this->sBest) | andn(hits.s <= this->sBest, this->isHit);
    const vbool<K> hit = andn(lanes & nearer, this->startsInside(box));
    if (none(hit)) return;
    hits.u = position(tile.grandchildren, 0, grandchild, hits.s);
    hits.v = position(tile.grandchildren, 1, grandchild, hits.s);
    hits.slopeX = hits.slopeY = vfloat<K>(zero);
    hits.fromAbove = hits.fromBelow = vbool<K>(false);
    this->reportHits(hit, 16 * m + grandchild, hits);
  }

private:
  __forceinline vfloat<K> position(const NodePlanes<16>& boxes, int axis, uint32_t leaf, const vfloat<K>& s) const {
    const float lower = boxes.planes[axis][0][leaf], upper = boxes.planes[axis][1][leaf];
    const vfloat<K> at =
        (madd(s, this->nodeRays.D[axis], this->nodeRays.P[axis]) - vfloat<K>(lower)) / vfloat<K>(upper - lower);
    return min(max(at, vfloat<K>(zero)), vfloat<K>(1.0f));
  }
};
} // namespace embree::isa::cbvh
