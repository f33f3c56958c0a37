// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which of two hits in different blocks a ray reports. */

#include "../codec/block.h"
#include "../../common/isa.h"
#include "../../../common/math/constants.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

      /*! The nearest hit of a ray in blocks with frames, whatever it met first: of those that are reported at the same
       *  t that which was nearer before it was moved, and of equals that of the first block of the first face. */
      struct NearestHit
      {
        float tWorld = pos_inf;
        const Block* block = nullptr;

        /*! tfar: where the ray's hit so far is reported, of any kind */
        __forceinline bool isBehind (float t, float tWorld, const Block* block, float tfar) const {
          return likely(t < tfar) ? false : t > tfar || tWorld > this->tWorld || (tWorld == this->tWorld && this->block && !comesBefore(block,this->block));
        }

        __forceinline void set (float tWorld, const Block* block) { this->tWorld = tWorld; this->block = block; }

      private:
        static bool comesBefore (const Block* a, const Block* b)
        {
          if (a->geomID != b->geomID) return a->geomID < b->geomID;
          if (a->primID != b->primID) return a->primID < b->primID;
          return a->tiling != b->tiling ? a->tiling < b->tiling : a->info < b->info;
        }
      };
    }
  }
}
