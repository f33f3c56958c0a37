// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory of a surface's blocks and the nodes above them. It grows during the build and is released as a whole. */

#include "../embree/scene.h"

namespace embree
{
  namespace cbvh
  {
    class BlockMemory
    {
    public:
      explicit BlockMemory (Device* device);
      ~BlockMemory ();
      BlockMemory (const BlockMemory&) = delete;
      BlockMemory& operator= (const BlockMemory&) = delete;

      /*! Must be called first. bytes: estimated size; selects Embree's allocator, from which tasks allocate
       *  concurrently. 0 allocates each piece separately: scenes may have many surfaces of few blocks, for which an
       *  allocator wastes memory. */
      void reserve (size_t bytes);

      /*! Null after reserve(0). */
      FastAllocator* pool () { return allocator.get(); }

      /*! Allocates with the alignment of blocks. Has the signature of Embree's allocators. */
      void* operator() (size_t bytes, size_t = 0);

      /*! Call it after the last allocation. */
      void end ();

    private:
      struct Piece { void* data; size_t bytes; };

      Device* device;
      std::unique_ptr<FastAllocator> allocator;
      std::vector<Piece> pieces;
      MutexSys mutex;
    };
  }
}
