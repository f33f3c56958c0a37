// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Per-thread cache of decoded blocks, because consecutive rays mostly reach the same blocks, and decoding is most of a
 * ray's cost. Entries (exact/cache.h, exact/mesh_cache.h, paper/node_cache.h) are direct-mapped by block address. */

#include "../embree/simd.h"
#include <atomic>
#include <cstddef>

namespace embree::cbvh {
/*! Bits of a mask, one per type of cache. */
enum ThreadCaches : unsigned { vertCache = 1, motionCache = 2, meshCache = 4, nodeCache = 8, meshMotionCache = 16 };

/*! Returns the size of one thread's caches. caches: mask of ThreadCaches. */
size_t threadCacheBytes(unsigned caches);

/*! Must be called after blocks are built or loaded and before they are traced: released blocks may have had their
 *  addresses. Threads clear their caches at the next use. */
void invalidateThreadCaches();

extern std::atomic<unsigned> cacheGeneration; //!< incremented by invalidateThreadCaches()

/*! Hash of an address, not reduced to a number of entries. Multiplicative hashing by a prime near 2^32 divided by
 *  the golden ratio (Knuth, The Art of Computer Programming, volume 3, section 6.4). */
__forceinline size_t hashOfBlock(const void* block) { return size_t(block) / 16 * 0x9E3779B1u >> 16; }

/*! Locality-preserving hash: grows by 1 every `step` bytes, so that neighboring blocks of at least `step` bytes
 *  have different entries, except across multiples of 256 KiB. Each such range has another offset: blocks at equal
 *  distances would otherwise share few entries. */
__forceinline size_t localityHashOfBlock(const void* block, size_t step) {
  return size_t(block) / step + (((size_t(block) >> 18) * 0x9E3779B1u) >> 12);
}

/*! 1 if a core's second-level cache has at least 1 MiB, otherwise 0. Decoded blocks must fit into it, or they would
 *  evict the scene. */
extern const size_t largeCaches;

/*! Direct-mapped array of `count` entries, or 2*count if largeCaches is 1. Entries from size() on occupy no memory.
 *  numExtra: further entries, for users that access consecutive entries from an index on. */
template<typename Entry, size_t count, size_t numExtra = 0>
struct CacheEntries {
  /*! Index of the entry for a hash. */
  static __forceinline size_t indexOf(size_t hash) { return hash % count + (hash / count & largeCaches) * count; }
  static __forceinline size_t size() { return count + largeCaches * count + numExtra; }

  __forceinline Entry& operator[](size_t index) { return entries[index]; }

private:
  Entry entries[2 * count + numExtra];
};

/*! Entries: plain data with clear(), which invalidates all entries. */
template<typename Entries>
class ThreadCache : public Entries {
public:
  /*! The calling thread's cache, without outdated entries. */
  static __forceinline ThreadCache& ofThread() {
    ThreadCache* cache = current;
    const unsigned now = cacheGeneration.load(std::memory_order_relaxed);
    return cache != nullptr && cache->generation == now ? *cache : refresh(now);
  }

private:
  static ThreadCache& refresh(unsigned now);

  unsigned generation; //!< value of cacheGeneration

  /* initial-exec: the default model of shared libraries calls a function for each access */
  static __thread ThreadCache* current __attribute__((tls_model("initial-exec")));
};
} // namespace embree::cbvh
