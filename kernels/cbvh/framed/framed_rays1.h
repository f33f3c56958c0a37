// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The paper's representations, as used by single-ray traversal. traversal/kind_visitors1.h replaces this file in
 * libraries without them. */

#include "../base/primitive_type.h"
#include "block_intersector1.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      class FramedRay
      {
      public:
        __forceinline explicit FramedRay (float tfar) : state(tfar) {}

        /*! type: of a leaf of the top-level tree. */
        static __forceinline bool isFramed (size_t type) { return type == FRAMED_BLOCK; }

        /*! t: where the ray enters the next block's bounds. */
        __forceinline void setEnter (float t) { state.enter = t; }

        /*! True if a hit was accepted. */
        template<typename RayType>
        __forceinline bool intersect (RayType& ray, IntersectContext* context, const void* prim)
        {
          if (unlikely(!isUsable(prim,FRAMED_FORM))) return false;
          const Block* const block = (const Block*)prim;
          state.set(ray);
          switch (kindOf(block->info)) {
          case kindLeaf : return BlockIntersector1<LeafVisitor1 >::intersect(ray,context,state,block);
          case kindVoxel: return BlockIntersector1<VoxelVisitor1>::intersect(ray,context,state,block);
          case kindGrid : return BlockIntersector1<GridVisitor1 >::intersect(ray,context,state,block);
          default       : return false;
          }
        }

        /*! Call it after the traversal. Returns the final tfar. */
        __forceinline float end (float tfar) const { return state.nearest.end(tfar); }

      private:
        RayState state;
      };
    }
  }
}
