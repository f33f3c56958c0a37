// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory of a surface's blocks and of the tree nodes above them, which all threads of a build allocate. The destructor
 * frees all of it; single blocks are never freed. */

#include "../embree/scene.h"

namespace embree::cbvh {
class BlockMemory {
public:
  explicit BlockMemory(Device* device);
  ~BlockMemory();
  BlockMemory(const BlockMemory&) = delete;
  BlockMemory& operator=(const BlockMemory&) = delete;

  /*! Must not be called after an allocation. bytes: estimated size of a large surface, whose small pieces come from
   *  Embree's allocator. 0, or no call, for a small surface: all pieces are allocated separately, because chunks
   *  would stay mostly empty. */
  void reserve(size_t bytes);

  /*! Embree's allocator, for builders that require it. Null without reserve() or after reserve(0). */
  FastAllocator* pool() { return allocator.get(); }

  /*! Allocates with the alignment of blocks. Thread-safe. Throws if out of memory, or if the application's memory
   *  monitor refuses. */
  void* allocate(size_t bytes);

  /*! Must be called after the last allocation: detaches the threads from Embree's allocator. */
  void detachThreads();

private:
  struct Piece {
    void* data;
    size_t bytes;
  };

  /*! Embree's allocator has chunks of a twentieth of the estimated size, at most 2 MiB, and loses the remainder of
   *  a chunk if the next piece does not fit. So pieces above an eighth of a chunk are allocated separately. */
  static const size_t chunks = 20, maxChunkBytes = size_t(2) << 20, piecesPerChunk = 8;

  Device* device;
  std::unique_ptr<FastAllocator> allocator;
  size_t maxPooledBytes = 0; //!< largest piece from the allocator
  std::vector<Piece> pieces;
  MutexSys mutex;
};
} // namespace embree::cbvh
