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
       *  past their bounds at the top level (framed/block_bounds.h). Hits are compared by their distance, but not less
       *  than the distance at which the ray enters the bounds of the block. Traversal culls with this distance, so it
       *  is the ray's tfar during traversal. Ties are resolved by the hits' own distances, then by the order of faces
       *  and blocks. After the traversal, the ray's tfar becomes the hit's own distance. */
      struct NearestHit
      {
        float t = pos_inf;   //!< distance that hits are compared by
        float own = pos_inf; //!< distance of the hit itself
        const Block* block = nullptr;

        /*! True if the stored hit takes precedence over another. tfar: tfar of the ray, whose hit can be of another
         *  kind. */
        __forceinline bool isBefore (float otherT, float otherOwn, const Block* other, float tfar,
                                     const SurfaceIDs& ids) const {
          return likely(otherT < tfar) ? false : otherT > tfar || otherOwn > own
            || (otherOwn == own && block && !hasPrecedence(other,block,ids));
        }

        __forceinline void set (float t, float own, const Block* block) {
          this->t = t; this->own = own; this->block = block;
        }

        /*! The final tfar of the ray. */
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
