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

      /*! Must be called first. bytes: estimated size, or 0 if there are few blocks. With 0 each piece is allocated
       *  separately, because there may be many such surfaces. Otherwise tasks allocate concurrently from Embree's
       *  allocator. */
      void expect (size_t bytes);

      /*! Null if there are few blocks. */
      FastAllocator* pool () { return shared.get(); }

      /*! Allocates memory that is aligned for blocks. Has the signature of Embree's allocators. */
      void* operator() (size_t bytes, size_t = 0);

      /*! Ends allocation. */
      void end ();

    private:
      struct Piece { void* data; size_t bytes; };

      Device* device;
      std::unique_ptr<FastAllocator> shared;
      std::vector<Piece> pieces;
      MutexSys mutex;          //!< protects pieces
    };
  }
}
