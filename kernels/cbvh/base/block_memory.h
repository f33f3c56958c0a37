// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory of a surface's blocks and of the tree nodes above them, which all threads of a build allocate. The destructor
 * frees all of it; single blocks are never freed. Blocks of large surfaces lie in large pages of Linux if it has them
 * (transparent huge pages, with the usual setting madvise, or always). */

#include "../embree/scene.h"

namespace embree::cbvh {
class BlockMemory {
public:
  explicit BlockMemory(Device* device);
  ~BlockMemory();
  BlockMemory(const BlockMemory&) = delete;
  BlockMemory& operator=(const BlockMemory&) = delete;

  /*! Must not be called after an allocation. blockBytes, nodeBytes: estimated sizes for a surface that is not small. No
   *  call for a small surface: all blocks are allocated separately, because pieces would stay mostly empty. */
  void reserve(size_t blockBytes, size_t nodeBytes);

  /*! Embree's allocator, for builders of trees. Null without reserve(). */
  FastAllocator* pool() { return allocator.get(); }

  /*! Allocates with the alignment of blocks. Thread-safe. Throws if out of memory, or if the application's memory
   *  monitor refuses. */
  void* allocate(size_t bytes);

  /*! Must be called after the last allocation: releases what is unused, and detaches the threads from Embree's
   *  allocator. */
  void finish();

private:
  /*! Blocks are allocated one after the other in pieces. */
  struct Piece {
    char* data;
    size_t bytes;
    bool isMapped; //!< by addLargePages
  };

  /*! A piece ends if the next allocation does not fit. Thus larger ones, in parts of a piece, have their own. */
  static const size_t allocationsPerPiece = 8;

  void reservePiece();
  void addPiece(size_t bytes);
  void addLargePages();

  Device* device;
  std::unique_ptr<FastAllocator> allocator;
  size_t pieceBytes = 0; //!< 0: each allocation has its own piece
  std::vector<Piece> pieces;
  char *next = nullptr, *end = nullptr; //!< free memory of the current piece
  MutexSys mutex;
};
} // namespace embree::cbvh
