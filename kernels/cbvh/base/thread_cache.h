// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Cache of recently decoded data of blocks, per thread. Consecutive rays mostly reach the same blocks, and decoding
 * them is most of the cost of a ray.
 *
 * Entries (vert/cache.h, framed/node_cache.h) are direct-mapped by the address of a block. A new block may have the
 * address of an old one that was traced and released, so each build invalidates all caches at its end. */

#include "../embree/simd.h"
#include <atomic>
#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    /*! The caches of a thread, as bits of a mask. */
    enum ThreadCaches : unsigned { vertCache = 1, motionCache = 2, meshCache = 4, nodeCache = 8, meshMotionCache = 16 };

    /*! Size in bytes of the caches in a mask of ThreadCaches, per thread. */
    size_t threadCacheBytes (unsigned caches);

    /*! Invalidates all caches. Call it after blocks are built and before they are traced. */
    void invalidateThreadCaches ();

    /*! Number of calls of invalidateThreadCaches. */
    extern std::atomic<unsigned> cacheGeneration;

    /*! Hash of a block, before it is reduced to the number of entries. */
    __forceinline size_t hashOfBlock (const void* block) { return size_t(block)/16*0x9E3779B1u >> 16; }

    /*! Like hashOfBlock, but consecutive `bytes` bytes of memory have consecutive values, so that neighboring blocks
     *  never share an entry. A hash shifts each range of 256 KiB. Without it, blocks at equal distances would share a
     *  few entries. */
    __forceinline size_t slotOfBlock (const void* block, size_t bytes) {
      return size_t(block)/bytes + (((size_t(block) >> 18)*0x9E3779B1u) >> 12);
    }

    /*! 1 if the second-level cache of a core holds at least 1 MiB, otherwise 0. A thread's cache of decoded blocks must
     *  fit into it, or it would evict the scene. */
    extern const size_t largeCaches;

    /*! A direct-mapped array with `count` entries, or twice as many if largeCaches is 1. Entries that are not used are
     *  never touched, and so occupy no memory. numAfter: each slot is followed by so many entries. */
    template<typename Entry, size_t count, size_t numAfter = 0>
    struct CacheEntries
    {
      static __forceinline size_t slot (size_t hash) { return hash % count + (hash/count & largeCaches)*count; }
      static __forceinline size_t size () { return count + largeCaches*count + numAfter; }

      __forceinline Entry& operator[] (size_t slot) { return entries[slot]; }

    private:
      Entry entries[2*count+numAfter];
    };

    /*! Entries: plain data with clear(), which invalidates all entries. */
    template<typename Entries>
    class ThreadCache : public Entries
    {
    public:
      /*! The cache of the calling thread, without outdated entries. */
      static __forceinline ThreadCache& ofThread ()
      {
        ThreadCache* cache = current;
        const unsigned now = cacheGeneration.load(std::memory_order_relaxed);
        return cache != nullptr && cache->generation == now ? *cache : renew(now);
      }

    private:
      static ThreadCache& renew (unsigned now);

      unsigned generation; //!< value of cacheGeneration

      static __thread ThreadCache* current __attribute__((tls_model("initial-exec")));
    };
  }
}
