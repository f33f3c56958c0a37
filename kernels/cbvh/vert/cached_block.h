// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A block of cVERT as the thread's cache has it, or gets it now. What it refers to lasts until a hit is
 * reported: a filter may trace rays. */

#include "../base/mapped_blocks.h"
#include "boxes.h"
#include "decoder.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      class CachedVertBlock
      {
      public:
        /*! ray: VertRay or VertRays, with the thread's cache */
        template<typename RayOrRays>
        __forceinline CachedVertBlock (const RayOrRays& ray, const VertHeader* block)
          : cache(*ray.cache), block(block), slot(cache.slot(block)) {}

        /*! its boxes, or null if they are not decoded */
        __forceinline const VertBoxes* decodedBoxes () const { return likely(slot.block == block) ? &slot : nullptr; }

        /*! Returns false if a ray misses the bounds of the block between tNear and tFar. Decodes nothing; the block
         *  must be usable. */
        __forceinline bool mayMeet (const VertRayAxes<float>& ray, float tNear, float tFar) const {
          return unlikely(isRaw(block->boxForm)) || meetsBounds<float>(ray,block,tNear,tFar);
        }

        /*! Returns false if the block is damaged: nothing of it may be read, not even its header. */
        __forceinline bool isUsable () const { return cbvh::isUsable(block,VERT_FORM); }

        /*! boxes of groups of a usable block */
        __forceinline const VertBoxes& boxes () const
        {
          if (unlikely(slot.block != block)) decode();
          return slot;
        }

        /*! of the group in a lane, in the world */
        __forceinline const CellVertices& vertices (uint32_t lane) const
        {
          const size_t slot = cache.slot(block,lane);
          if (unlikely(cache.key(slot) != keyOfGroup(block,lane))) decode(lane,slot);
          return cache.vertices(slot);
        }

      private:
        __noinline void decode () const
        {
          /* The block at once, as long as most are: where its groups' fields lie is known late, and memory
           * that is waited for then is not hidden by anything. */
          for (int line=1; line<12; line++) prefetchL1((const char*)block + 64*line);
          slot.block = block;
          VertDecoder(block).decode(slot);
        }

        __noinline void decode (uint32_t lane, size_t slot) const
        {
          const VertBoxes& boxes = this->boxes();
          cache.key(slot) = keyOfGroup(block,lane);
          VertDecoder(block).vertices(boxes,lane,cache.vertices(slot));
        }

        VertCache& cache;
        const VertHeader* block;
        VertBoxes& slot; //!< of its boxes
      };
    }
  }
}
