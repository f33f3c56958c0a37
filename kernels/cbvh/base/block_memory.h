// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory of the blocks of a surface and of the nodes above them. It grows while tasks build the surface, and is
 * released as a whole. */

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

      /*! Must be called first. bytes: estimated size, or 0 if there are few blocks. 0 allocates each piece separately:
       *  a scene may have many surfaces of few blocks, and an allocator for each of them would waste memory. Any other
       *  value selects Embree's allocator, from which tasks allocate concurrently. */
      void expect (size_t bytes);

      /*! Returns Embree's allocator, or null after expect(0). */
      FastAllocator* pool () { return allocator.get(); }

      /*! Allocates memory with the alignment of blocks. Has the signature of Embree's allocators. */
      void* operator() (size_t bytes, size_t = 0);

      /*! Must be called after the last allocation. */
      void end ();

    private:
      struct Piece { void* data; size_t bytes; };

      Device* device;
      std::unique_ptr<FastAllocator> allocator;
      std::vector<Piece> pieces;
      MutexSys mutex;          //!< protects pieces
    };
  }
}
