// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The intersector of each kind of leaves, by the type of the primitive and the kind in its header. */

#include "../base/mapped_blocks.h"
#include "../framed/block_intersector1.h"
#include "../vert/intersector1.h"
#include "../base/primitive_type.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! false for a primitive that is not a block; else found: whether a hit was accepted */
      template<typename RayType>
      __forceinline bool intersectBlock (size_t type, RayType& ray, IntersectContext* context, RayState& state, VertRay& vertRay, const void* prim, bool& found)
      {
        const Block* block = (const Block*)prim;
        if (type == VERT_BLOCK) { found = intersectVert(ray,context,vertRay,(const VertHeader*)prim); return true; }
        if (type != FRAMED_BLOCK) return false;
        if (unlikely(!isUsable(prim,false))) { found = false; return true; }
        state.set(ray);
        switch (kindOf(block->info)) {
        case kindLeaf : found = BlockIntersector1<LeafVisitor1 >::intersect(ray,context,state,block); return true;
        case kindVoxel: found = BlockIntersector1<VoxelVisitor1>::intersect(ray,context,state,block); return true;
        case kindGrid : found = BlockIntersector1<GridVisitor1 >::intersect(ray,context,state,block); return true;
        default       : found = false; return true;
        }
      }
    }
  }
}
