// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The rule that makes hits in blocks with frames independent of the order in which blocks are visited. */

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

      /*! The nearest hit of a ray in blocks with frames. Blocks extend slightly past their top-level bounds
       *  (block_bounds.h), so a ray can hit a block before it enters the block's bounds; traversal may then already
       *  have culled the block. Hits are therefore compared by the greater one of two distances: the hit's own, and the
       *  one at which the ray enters the block's bounds. This distance is the ray's tfar during the traversal; at its
       *  end, tfar becomes the hit's own distance. Ties are resolved by own distances, then by the order of faces and
       *  blocks. */
      struct NearestHit
      {
        float comparedT = pos_inf; //!< distance by which hits are compared
        float hitT = pos_inf;      //!< distance of the hit itself
        const Block* block = nullptr;

        /*! True if the current hit takes precedence over another one. tfar: the ray's current one; its hit can be of
         *  another kind than blocks with frames. */
        __forceinline bool isBefore (float otherComparedT, float otherHitT, const Block* other, float tfar,
                                     const SurfaceIDs& ids) const {
          return likely(otherComparedT < tfar) ? false : otherComparedT > tfar || otherHitT > hitT
            || (otherHitT == hitT && block && !hasPrecedence(other,block,ids));
        }

        __forceinline void set (float comparedT, float hitT, const Block* block) {
          this->comparedT = comparedT; this->hitT = hitT; this->block = block;
        }

        /*! Returns the ray's final tfar: the hit's own distance, if the ray's nearest hit is this one. */
        __forceinline float finalTfar (float tfar) const { return block && tfar == comparedT ? hitT : tfar; }

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
