// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. */

#include "../base/mapped_blocks.h"
#if !defined(EMBREE_CBVH_NO_PAPER)
#include "../framed/node_cache.h"
#endif
#include "../vert/mesh_cache.h"
#include <cstdlib>
#include <new>

namespace embree
{
  namespace cbvh
  {
    std::atomic<unsigned> cacheGeneration(0);

    /* Set by the code that maps blocks, so that codecs do not depend on it. */
    std::atomic<size_t> mappedBegin(0), mappedBytes(0);
    std::atomic<bool (*) (const void* block, BlockForm form)> isMappedBlockValid(nullptr);

    size_t threadCacheBytes (unsigned caches)
    {
      size_t bytes = 0;
      if (caches & vertCache) bytes += sizeof(ThreadCache<VertEntries>);
      if (caches & motionCache) bytes += sizeof(ThreadCache<MotionEntries>);
      if (caches & meshCache) bytes += sizeof(ThreadCache<MeshEntries>);
      if (caches & meshMotionCache) bytes += sizeof(ThreadCache<MeshMotionEntries>);
#if !defined(EMBREE_CBVH_NO_PAPER)
      if (caches & nodeCache) bytes += sizeof(ThreadCache<NodeEntries>);
#endif
      return bytes;
    }

    void invalidateThreadCaches () { cacheGeneration.fetch_add(1); }

    template<typename Entries>
    __thread ThreadCache<Entries>* ThreadCache<Entries>::current = nullptr;

    template<typename Entries>
    ThreadCache<Entries>& ThreadCache<Entries>::renew (unsigned now)
    {
      struct Owner { ~Owner () { std::free(current); current = nullptr; } };
      if (current == nullptr) {
        static thread_local Owner owner; // destroyed when the thread ends
        (void)owner;
        void* memory = nullptr;
        if (posix_memalign(&memory,64,sizeof(ThreadCache)) != 0) throw std::bad_alloc();
        current = (ThreadCache*)memory;
      }
      current->clear();
      current->generation = now;
      return *current;
    }

    static_assert(sizeof(VertEntries) < 512*1024 && sizeof(MotionEntries) < 512*1024 && sizeof(MeshEntries) < 512*1024
      && sizeof(MeshMotionEntries) < 512*1024,
      "caches must be smaller than 512 KiB, the second-level cache of a core: see docs/performance.md");

#if !defined(EMBREE_CBVH_NO_PAPER)
    template class ThreadCache<NodeEntries>;
#endif
    template class ThreadCache<VertEntries>;
    template class ThreadCache<MotionEntries>;
    template class ThreadCache<MeshEntries>;
    template class ThreadCache<MeshMotionEntries>;
  }
}
