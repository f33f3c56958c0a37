// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Memory of the per-thread caches (base/thread_cache.h), which all instruction sets share, and the variables by which
 * base/block_validity.h recognizes blocks of mapped files. Compiled once, for the library's lowest instruction set. */

#include "../base/block_validity.h"
#if !defined(EMBREE_CBVH_NO_PAPER)
#include "../paper/node_cache.h"
#endif
#include "../exact/mesh_cache.h"
#include <cstdlib>
#include <new>
#include <unistd.h>

namespace embree::cbvh {
std::atomic<unsigned> cacheGeneration(0);

#if defined(_SC_LEVEL2_CACHE_SIZE)
const size_t largeCaches = sysconf(_SC_LEVEL2_CACHE_SIZE) >= 1024 * 1024;
#else
const size_t largeCaches = 0;
#endif

/*! Bytes of a cache that a thread uses: half, unless largeCaches is 1. */
template<typename Entries>
static size_t bytesOf() {
  return sizeof(ThreadCache<Entries>) / (2 - largeCaches);
}

/* files/mapped_blocks.cpp sets them. They are defined here, so that decoders do not depend on files. */
std::atomic<size_t> mappedBegin(0), mappedBytes(0);
std::atomic<BlockValidator> mappedBlockValidator(nullptr);

size_t threadCacheBytes(unsigned caches) {
  size_t bytes = 0;
  if (caches & vertCache) bytes += bytesOf<VertEntries>();
  if (caches & motionCache) bytes += bytesOf<MotionEntries>();
  if (caches & meshCache) bytes += bytesOf<MeshEntries>();
  if (caches & meshMotionCache) bytes += bytesOf<MeshMotionEntries>();
#if !defined(EMBREE_CBVH_NO_PAPER)
  if (caches & nodeCache) bytes += sizeof(ThreadCache<NodeEntries>);
#endif
  return bytes;
}

void invalidateThreadCaches() { cacheGeneration.fetch_add(1); }

template<typename Entries>
__thread ThreadCache<Entries>* ThreadCache<Entries>::current = nullptr;

template<typename Entries>
ThreadCache<Entries>& ThreadCache<Entries>::refresh(unsigned now) {
  // frees the thread's cache at the thread's end
  struct Owner {
    ~Owner() {
      std::free(current);
      current = nullptr;
    }
  };
  if (current == nullptr) {
    static thread_local Owner owner;
    (void)owner; // only its destructor is needed
    void* memory = nullptr;
    if (posix_memalign(&memory, 64, sizeof(ThreadCache)) != 0) throw std::bad_alloc();
    current = (ThreadCache*)memory;
  }
  current->Entries::clear(); // qualified: otherwise, GCC 16 does not find it in the base class
  current->generation = now;
  return *current;
}

/*! True if a large cache fits into the second-level cache that largeCaches requires. */
template<typename Entries>
constexpr bool fits() {
  return sizeof(ThreadCache<Entries>) < 1024 * 1024;
}

static_assert(fits<VertEntries>() && fits<MotionEntries>() && fits<MeshEntries>() && fits<MeshMotionEntries>(),
              "large caches must fit into a second-level cache of 1 MiB, others into 512 KiB");

#if !defined(EMBREE_CBVH_NO_PAPER)
template class ThreadCache<NodeEntries>;
#endif
template class ThreadCache<VertEntries>;
template class ThreadCache<MotionEntries>;
template class ThreadCache<MeshEntries>;
template class ThreadCache<MeshMotionEntries>;
} // namespace embree::cbvh
