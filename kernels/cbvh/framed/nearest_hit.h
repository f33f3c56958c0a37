// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which of two hits in different blocks a ray reports. */

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

      /*! The hit of a ray in blocks with frames that counts, whatever it met first. Blocks reach a little past their
       *  bounds at the top level (framed/block_bounds.h): what counts is where a hit is, but not before the ray enters the bounds of
       *  its block. That is the ray's tfar while it is traced, as traversal culls by it; of equals the nearer hit counts,
       *  then that of the first block of the first face. In the end the ray gets the hit's own distance. */
      struct NearestHit
      {
        float t = pos_inf;   //!< what counts
        float own = pos_inf; //!< where the hit is
        const Block* block = nullptr;

        /*! whether another hit comes after this one; tfar: of the ray, whose hit may be of another kind;
         *  ids: of the scene's surfaces */
        __forceinline bool isBefore (float otherT, float otherOwn, const Block* other, float tfar, const SurfaceIDs& ids) const {
          return likely(otherT < tfar) ? false : otherT > tfar || otherOwn > own || (otherOwn == own && block && !comesBefore(other,block,ids));
        }

        __forceinline void set (float t, float own, const Block* block) { this->t = t; this->own = own; this->block = block; }

        /*! the ray's tfar in the end */
        __forceinline float end (float tfar) const { return block && tfar == t ? own : tfar; }

      private:
        static bool comesBefore (const Block* a, const Block* b, const SurfaceIDs& ids)
        {
          if (a->surface != b->surface) return ids[a->surface] < ids[b->surface];
          if (a->primID != b->primID) return a->primID < b->primID;
          return a->tiling != b->tiling ? a->tiling < b->tiling : a->info < b->info;
        }
      };
    }
  }
}
