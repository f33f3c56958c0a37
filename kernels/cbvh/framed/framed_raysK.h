// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* framed_rays1.h for packets. A build without the paper's representations uses traversal/no_framed_raysK.h instead. */

#include "block_intersectorK.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      template<int K>
      class FramedRaysK
      {
      public:
        __forceinline explicit FramedRaysK (const vfloat<K>& tfar) : state(tfar) {}

        /*! Must be called before intersect(). t: distances at which rays enter the bounds of the next block. */
        __forceinline void setEnter (const vfloat<K>& t) { state.enter = t; }

        /*! Returns the rays that accepted a hit. */
        template<typename Rays>
        __forceinline vbool<K> intersect (const vbool<K>& valid, Rays& rays, IntersectContext* context,
                                          const void* prim)
        {
          if (unlikely(!isUsable(prim,FRAMED_FORMAT))) return vbool<K>(false);
          const Block* const block = (const Block*)prim;
          state.set(rays);
          switch (kindOf(block->info)) {
          case kindLeaf : return BlockIntersectorK<K,LeafVisitorK >::intersect(valid,rays,context,state,block);
          case kindVoxel: return BlockIntersectorK<K,VoxelVisitorK>::intersect(valid,rays,context,state,block);
          case kindGrid : return BlockIntersectorK<K,GridVisitorK >::intersect(valid,rays,context,state,block);
          default       : return vbool<K>(false);
          }
        }

        /*! Sets the final tfar of rays. Must be called after the traversal. */
        __forceinline void setFinalTfar (const vbool<K>& valid, vfloat<K>& tfar) const {
          state.setFinalTfar(valid,tfar);
        }

      private:
        RayStates<K> state;
      };
    }
  }
}
