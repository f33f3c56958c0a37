// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Interface of the paper's representations for single-ray traversal: selects the intersector by the block's kind.
 * traversal/kind_visitors1.h contains the replacement for libraries without them. */

#include "../base/primitive_type.h"
#include "block_intersector1.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! State of a ray for all blocks with frames that it visits. */
      class FramedRay
      {
      public:
        /*! tfar: the ray's, before any hit. */
        __forceinline explicit FramedRay (float tfar) : state(tfar) {}

        /*! True if a leaf of the top-level BVH is a block with a frame. type: see base/primitive_type.h. */
        static __forceinline bool isFramed (size_t type) { return type == FRAMED_BLOCK; }

        /*! Must be called before intersect(). t: distance at which the ray enters the bounds of the next block. */
        __forceinline void setEnter (float t) { state.enter = t; }

        /*! Returns true if a hit was accepted. prim: a block with a frame; a damaged one has no hits. */
        template<typename RayType>
        __forceinline bool intersect (RayType& ray, IntersectContext* context, const void* prim)
        {
          if (unlikely(!isUsable(prim,FRAMED_FORMAT))) return false;
          const Block* const block = (const Block*)prim;
          state.set(ray);
          switch (kindOf(block->info)) {
          case kindLeaf : return BlockIntersector1<LeafVisitor1 >::intersect(ray,context,state,block);
          case kindVoxel: return BlockIntersector1<VoxelVisitor1>::intersect(ray,context,state,block);
          case kindGrid : return BlockIntersector1<GridVisitor1 >::intersect(ray,context,state,block);
          default       : return false;
          }
        }

        /*! Returns the ray's final tfar, see NearestHit. Must be called after the traversal. */
        __forceinline float finalTfar (float tfar) const { return state.nearest.finalTfar(tfar); }

      private:
        RayState state;
      };
    }
  }
}
