// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "vert_cache.h"
#include <mm_malloc.h>
#include <new>

namespace embree
{
  namespace cbvh
  {
    std::atomic<unsigned> VertCache::generation(0);
    __thread VertCache* VertCache::current = nullptr;

    VertCache& VertCache::renew (unsigned now)
    {
      struct Owner { ~Owner () { _mm_free(current); current = nullptr; } };
      if (current == nullptr) {
        static thread_local Owner owner; // ends with the thread
        (void)owner;
        current = (VertCache*)_mm_malloc(sizeof(VertCache),64);
        if (current == nullptr) throw std::bad_alloc();
      }
      for (Block& block : current->blocks) block.block = nullptr;
      for (Group& group : current->groups) group.block = nullptr;
      current->made = now;
      return *current;
    }
  }
}
