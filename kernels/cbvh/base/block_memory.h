// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory of the blocks of one surface, and of the nodes above them. It grows while the surface is built, by all tasks at once, and
 * is released as a whole. */

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

      /*! Comes first: about how much there will be, or 0 if there are few blocks. Then each piece is allocated as it comes, as there may
       *  be many such surfaces; else tasks take their pieces from Embree's allocator, without waiting for each other. */
      void expect (size_t bytes);

      /*! null if there are few blocks */
      FastAllocator* pool () { return shared.get(); }

      /*! aligned to blocks; as Embree's own code asks allocators for memory */
      void* operator() (size_t bytes, size_t = 0);

      /*! no more is asked for */
      void end ();

    private:
      struct Piece { void* data; size_t bytes; };

      Device* device;
      std::unique_ptr<FastAllocator> shared;
      std::vector<Piece> pieces;
      MutexSys mutex;          //!< of pieces
    };
  }
}
