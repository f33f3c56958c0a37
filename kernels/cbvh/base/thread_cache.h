// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a thread has decoded of blocks lately. Rays that follow each other, of a picture or a packet,
 * mostly meet the blocks that the last ones met, and decoding these is most of what a ray costs.
 *
 * Entries (vert/cache.h, framed/node_cache.h) are found by the address of a block, in one place each. A block
 * that is built may come to lie where another was, which may have been traced and released since the build
 * began: at its end a build makes all that threads keep outdated. */

#include "../embree/simd.h"
#include <atomic>
#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    /*! comes after blocks are built, and before one of them is traced */
    void outdateThreadCaches ();

    /*! counts the builds */
    extern std::atomic<unsigned> cacheGeneration;

    /*! where a block is found, before it is cut to the number of entries */
    __forceinline size_t hashOfBlock (const void* block) { return size_t(block)/16*0x9E3779B1u >> 16; }

    /*! The same, with one place for so many bytes of memory, so that neighboring blocks never share a place. A hash
     *  shifts each range of 256 KiB: blocks at equal distances would otherwise share a few places. */
    __forceinline size_t placeOfBlock (const void* block, size_t bytes) {
      return size_t(block)/bytes + (((size_t(block) >> 18)*0x9E3779B1u) >> 12);
    }

    /*! Entries: plain data, with clear(), which makes them no block's */
    template<typename Entries>
    class ThreadCache : public Entries
    {
    public:
      /*! the calling thread's, without what is outdated */
      static __forceinline ThreadCache& ofThread ()
      {
        ThreadCache* cache = current;
        const unsigned now = cacheGeneration.load(std::memory_order_relaxed);
        return cache != nullptr && cache->made == now ? *cache : renew(now);
      }

    private:
      static ThreadCache& renew (unsigned now);

      unsigned made; //!< generation

      static __thread ThreadCache* current __attribute__((tls_model("initial-exec")));
    };
  }
}
