// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* framed_rays1.h for packets. traversal/no_framed_raysK.h replaces it in libraries without the paper's
 * representations. */

#include "../base/block_validity.h"
#include "block_intersectorK.h"

namespace embree::isa::cbvh {
template<int K>
class FramedRaysK {
public:
  __forceinline explicit FramedRaysK(const vfloat<K>& tfar) : state(tfar) {}

  /*! See FramedRay. */
  __forceinline void setEntryT(const vfloat<K>& t) { state.entryT = t; }

  /*! Returns the rays that accepted a hit. */
  template<typename Rays>
  __forceinline vbool<K> intersect(const vbool<K>& valid, Rays& rays, IntersectContext* context, const void* prim) {
    if (unlikely(!isBlockValid(prim, FRAMED_FORMAT))) return vbool<K>(false);
    const Block* const block = (const Block*)prim;
    state.set(rays);
    switch (kindOf(block->info)) {
    case kindLeaf: return BlockIntersectorK<K, LeafVisitorK>::intersect(valid, rays, context, state, block);
    case kindVoxel: return BlockIntersectorK<K, VoxelVisitorK>::intersect(valid, rays, context, state, block);
    case kindGrid: return BlockIntersectorK<K, GridVisitorK>::intersect(valid, rays, context, state, block);
    default: return vbool<K>(false);
    }
  }

  /*! Required after the traversal for closest hits: sets the final tfar. */
  __forceinline void setFinalTfar(const vbool<K>& valid, vfloat<K>& tfar) const { state.setFinalTfar(valid, tfar); }

private:
  RayStates<K> state;
};
} // namespace embree::isa::cbvh
