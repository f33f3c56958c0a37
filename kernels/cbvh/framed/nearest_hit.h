// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "block.h"
#include "../base/surface_ids.h"
#include "../embree/simd.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

      /*! The nearest hit of a ray in blocks with frames, independent of the order of visits. Blocks extend slightly
       *  past their top-level bounds (framed/block_bounds.h). Hits are compared by distance, but by no less than the
       *  distance at which the ray enters the block's bounds. Traversal culls with this distance, which is the ray's
       *  tfar until the end of traversal; then tfar becomes the hit's own distance. Ties are resolved by own distances,
       *  then by the order of faces and blocks. */
      struct NearestHit
      {
        float t = pos_inf;   //!< distance by which hits are compared
        float own = pos_inf; //!< distance of the hit itself
        const Block* block = nullptr;

        /*! tfar: the ray's, whose hit can be of another kind. */
        __forceinline bool isBefore (float otherT, float otherOwn, const Block* other, float tfar,
                                     const SurfaceIDs& ids) const {
          return likely(otherT < tfar) ? false : otherT > tfar || otherOwn > own
            || (otherOwn == own && block && !hasPrecedence(other,block,ids));
        }

        __forceinline void set (float t, float own, const Block* block) {
          this->t = t; this->own = own; this->block = block;
        }

        /*! The ray's final tfar. */
        __forceinline float end (float tfar) const { return block && tfar == t ? own : tfar; }

      private:
        static bool hasPrecedence (const Block* a, const Block* b, const SurfaceIDs& ids)
        {
          if (a->surface != b->surface) return ids[a->surface] < ids[b->surface];
          if (a->primID != b->primID) return a->primID < b->primID;
          return a->tiling != b->tiling ? a->tiling < b->tiling : a->info < b->info;
        }
      };
    }
  }
}
