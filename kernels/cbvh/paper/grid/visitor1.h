// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Visitor of block_walk1.h for leaves of cGRID, with the triangle test of Embree's GRID. */

#include "../block_visitor1.h"
#include "leaf.h"

namespace embree::isa::cbvh {
/*! Returns Embree's epilogue for M triangles of a block. */
template<int M>
__forceinline Intersect1EpilogMU<M, true> gridEpilog(RayHit& ray, IntersectContext* context, const Block* block) {
  return Intersect1EpilogMU<M, true>(ray, context, geomIDOf(context, block->surface), block->primID);
}
template<int M>
__forceinline Occluded1EpilogMU<M, true> gridEpilog(Ray& ray, IntersectContext* context, const Block* block) {
  return Occluded1EpilogMU<M, true>(ray, context, geomIDOf(context, block->surface), block->primID);
}

template<typename RayType>
struct GridVisitor1 : public BlockVisitor1<RayType> {
  static const uint32_t kind = kindGrid;
  using BlockVisitor1<RayType>::BlockVisitor1;

  __forceinline bool leaf(const NodeEntries::Tile&, uint32_t m, uint32_t grandchild, const BoxRanges<16>&) {
    if (!testGridLeaf(this->block, 16 * m + grandchild, IsAnyHit<RayType>::value, *this)) return false;
    this->isHit = true;
    this->sBest = this->local.parameterAfter(this->state.rcpScale, this->ray.tfar);
    return IsAnyHit<RayType>::value;
  }

  /*! For GridLeaf. */
  template<int M, typename MapUV>
  __forceinline bool intersectTriangles(const Vec3vf<M>& v0, const Vec3vf<M>& v1, const Vec3vf<M>& v2,
                                        const MapUV& mapUV) const {
    return PlueckerIntersector1<M>(this->ray, nullptr)
        .intersect(this->ray, v0, v1, v2, mapUV, gridEpilog<M>(this->ray, this->context, this->block));
  }
};
} // namespace embree::isa::cbvh
