// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Visitor of block_walkK.h for leaves of cGRID. Tests one ray after the other. */

#include "../block_visitorK.h"
#include "leaf.h"

namespace embree::isa::cbvh {
/* Embree's epilogue for M triangles and ray k of a packet. */
template<int M, int K>
__forceinline Intersect1KEpilogMU<M, K, true> gridEpilog(RayHitK<K>& rays, size_t k, IntersectContext* context,
                                                         const Block* block) {
  return Intersect1KEpilogMU<M, K, true>(rays, k, context, geomIDOf(context, block->surface), block->primID);
}
template<int M, int K>
__forceinline Occluded1KEpilogMU<M, K, true> gridEpilog(RayK<K>& rays, size_t k, IntersectContext* context,
                                                        const Block* block) {
  return Occluded1KEpilogMU<M, K, true>(rays, k, context, geomIDOf(context, block->surface), block->primID);
}

template<int K, typename Rays>
struct GridVisitorK : public BlockVisitorK<K, Rays> {
  static const uint32_t kind = kindGrid;
  using BlockVisitorK<K, Rays>::BlockVisitorK;

  __forceinline void leaf(const NodeEntries::Tile&, uint32_t m, uint32_t grandchild, const BoxRangesK<K>&,
                          const vbool<K>& lanes) {
    uint32_t accepted = 0;
    vfloat<K> s(zero);
    for (uint32_t rest = uint32_t(movemask(lanes)); rest; rest &= rest - 1) {
      const uint32_t k = uint32_t(bsf(rest));
      if (!intersectLeaf(k, 16 * m + grandchild)) continue;
      accepted |= 1u << k;
      s[k] = this->nodeRays.parameterAfter(k, this->state.rcpScale[k], this->rays.tfar[k]);
    }
    this->accept(vbool<K>(int(accepted)));
    this->sBest = select(vbool<K>(int(accepted)), s, this->sBest);
  }

private:
  /*! For GridLeaf. */
  struct Test {
    Rays& rays;
    IntersectContext* context;
    const Block* block;
    size_t k;

    template<int M, typename MapUV>
    __forceinline bool intersectTriangles(const Vec3vf<M>& v0, const Vec3vf<M>& v1, const Vec3vf<M>& v2,
                                          const MapUV& mapUV) const {
      return PlueckerIntersectorK<M, K>().intersect(rays, k, v0, v1, v2, mapUV, gridEpilog<M>(rays, k, context, block));
    }
  };

  /*! Returns true if ray k accepted a hit. */
  __noinline bool intersectLeaf(size_t k, uint32_t leaf) const {
    return testGridLeaf(this->block, leaf, IsAnyHit<Rays>::value, Test{this->rays, this->context, this->block, k});
  }
};
} // namespace embree::isa::cbvh
