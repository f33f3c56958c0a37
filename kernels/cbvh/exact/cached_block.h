// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Access to a decoded cVERT block, which is decoded into the thread's cache if necessary. References into the cache
 * become invalid once a hit is reported, because a filter function may trace further rays. */

#include "../base/block_validity.h"
#include "boxes.h"
#include "decoder.h"

namespace embree::isa::cbvh {
class CachedVertBlock {
public:
  static const bool isMesh = false; //!< see hits1.h

  /*! ray: a VertRay or VertRays, after set(). */
  template<typename RayOrRays>
  __forceinline CachedVertBlock(const RayOrRays& ray, const VertHeader* block)
    : cache(*ray.cache),
      block(block),
      entry(cache.blockEntry(block)),
      firstGroupIndex(VertCache::firstGroupIndex(block)) {}

  /*! Returns the boxes of groups if they are in the cache, otherwise null. */
  __forceinline const GroupBoxes* decodedBoxes() const { return likely(entry.block == block) ? &entry : nullptr; }

  /*! Returns false if the ray misses the block's bounds between tNear and tFar; true for raw blocks. Requires
   *  isValid(). */
  __forceinline bool mayIntersect(const VertRayBase<float>& ray, float tNear, float tFar) const {
    return unlikely(isRaw(block->info)) || intersectsBounds<float>(ray, block, tNear, tFar);
  }

  /*! Returns false if the block is damaged. Then not even its header may be read. */
  __forceinline bool isValid() const { return cbvh::isBlockValid(block, VERT_BLOCK); }

  /*! Returns the boxes of groups; decodes them if necessary. Requires isValid(). */
  __forceinline const GroupBoxes& boxes() const {
    ensureDecoded();
    return entry;
  }

  /*! Returns the vertices of a group in world space; decodes them if necessary. Requires isValid(). */
  __forceinline const CellVertices& vertices(uint32_t lane) const {
    const size_t index = firstGroupIndex + lane;
    if (unlikely(cache.groupKey(index) != keyOfGroup(block, lane))) decode(lane, index);
    return cache.groupVertices(index);
  }

private:
  __forceinline void ensureDecoded() const {
    if (unlikely(entry.block != block)) decode();
  }

  __noinline void decode() const {
    // 12 cache lines cover most blocks; offsets of groups are known too late to prefetch only their fields
    for (int line = 1; line < 12; line++) prefetchL1((const char*)block + 64 * line);
    entry.block = block;
    VertDecoder(block).decode(entry);
  }

  __noinline void decode(uint32_t lane, size_t index) const {
    ensureDecoded();
    cache.groupKey(index) = keyOfGroup(block, lane);
    VertDecoder(block).vertices(entry, lane, cache.groupVertices(index));
  }

  VertCache& cache;
  const VertHeader* block;
  VertBlockEntry& entry;
  const size_t firstGroupIndex; //!< index of the entry of the group in lane 0
};
} // namespace embree::isa::cbvh
