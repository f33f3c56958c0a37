// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single rays in blocks with frames: selects the intersector by the block's kind. traversal/leaf_intersectors1.h
 * has a substitute for libraries without the paper's representations. */

#include "../base/block_validity.h"
#include "block_intersector1.h"

namespace embree::isa::cbvh {
/*! State of a ray for all blocks with frames that it visits. */
class FramedRay {
public:
  /*! tfar: before any hit. */
  __forceinline explicit FramedRay(float tfar) : state(tfar) {}

  /*! type: of a leaf of the top-level BVH, see base/primitive_type.h. */
  static __forceinline bool isFramed(size_t type) { return type == FRAMED_BLOCK; }

  /*! Required before intersect() for closest hits. t: distance to the entry into the next block's bounds. */
  __forceinline void setEntryT(float t) { state.entryT = t; }

  /*! Returns true if a hit was accepted. A damaged block has no hits. */
  template<typename RayType>
  __forceinline bool intersect(RayType& ray, IntersectContext* context, const void* prim) {
    if (unlikely(!isBlockValid(prim, FRAMED_FORMAT))) return false;
    const Block* const block = (const Block*)prim;
    state.set(ray);
    switch (kindOf(block->info)) {
    case kindLeaf: return BlockIntersector1<LeafVisitor1>::intersect(ray, context, state, block);
    case kindVoxel: return BlockIntersector1<VoxelVisitor1>::intersect(ray, context, state, block);
    case kindGrid: return BlockIntersector1<GridVisitor1>::intersect(ray, context, state, block);
    default: return false;
    }
  }

  /*! Required after the traversal for closest hits: returns the ray's final tfar, see NearestHit. */
  __forceinline float finalTfar(float tfar) const { return state.nearest.finalTfar(tfar); }

private:
  RayState state;
};
} // namespace embree::isa::cbvh
