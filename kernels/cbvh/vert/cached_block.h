// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Access to a decoded cVERT block, which is decoded into the thread's cache if necessary. References into the cache
 * become invalid once a hit is reported, because a filter function may trace further rays. */

#include "../base/block_validity.h"
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
        /*! ray: a VertRay or VertRays, after set(). */
        template<typename RayOrRays>
        __forceinline CachedVertBlock (const RayOrRays& ray, const VertHeader* block)
          : cache(*ray.cache), block(block), slot(cache.slot(block)),
            groupSlots(VertCache::groupSlots(block)) {}

        /*! Returns the boxes of groups if they are in the cache, otherwise null. */
        __forceinline const VertBoxes* decodedBoxes () const { return likely(slot.block == block) ? &slot : nullptr; }

        /*! Returns false if the ray misses the block's bounds between tNear and tFar. Decodes nothing. Requires
         *  isValid(). */
        __forceinline bool mayIntersect (const VertRayAxes<float>& ray, float tNear, float tFar) const {
          return unlikely(isRaw(block->info)) || intersectsBounds<float>(ray,block,tNear,tFar);
        }

        /*! Returns false if the block is damaged. Then not even its header may be read. */
        __forceinline bool isValid () const { return cbvh::isBlockValid(block,VERT_FORMAT); }

        /*! Returns the boxes of groups; decodes them if necessary. Requires isValid(). */
        __forceinline const VertBoxes& boxes () const
        {
          if (unlikely(slot.block != block)) decode();
          return slot;
        }

        /*! Returns the vertices of a group in world space; decodes them if necessary. Requires isValid(). */
        __forceinline const CellVertices& vertices (uint32_t lane) const
        {
          const size_t slot = groupSlots + lane;
          if (unlikely(cache.key(slot) != keyOfGroup(block,lane))) decode(lane,slot);
          return cache.vertices(slot);
        }

      private:
        __noinline void decode () const
        {
          // 12 cache lines cover most blocks; offsets of groups are known too late to prefetch only their fields
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
        VertBoxes& slot;
        const size_t groupSlots;
      };
    }
  }
}
