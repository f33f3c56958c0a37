// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Blocks of a mapped file are checked before they are first decoded (files/mapped_blocks.h), because a check when the
 * file is opened would read the whole file. Code that reads a block must call isBlockValid first, except for a moving
 * one: moving blocks are checked when their geometry is loaded. */

#include "../embree/simd.h"
#include "leaf_type.h"
#include <atomic>
#include <cstddef>

namespace embree::cbvh {
/*! Range of addresses that contains the mapped blocks of all files, and possibly other memory.
 *  mappedBytes is 0 if no file is mapped. Readers must load mappedBegin before mappedBytes. Writers first extend
 *  mappedBytes to all addresses, then change mappedBegin. If a reader sees an old and a new value, its range
 *  therefore still contains all blocks that its rays can reach. */
extern std::atomic<size_t> mappedBegin, mappedBytes;

/*! Returns false for a damaged block of a mapped file, and true for other memory in the range. */
typedef bool (*BlockValidator)(const void* block, BlockType type);
extern std::atomic<BlockValidator> mappedBlockValidator; //!< null until a file is mapped

/*! True if a block may be decoded. Otherwise callers must treat it as empty; the device receives one error per
 *  geometry. */
__forceinline bool isBlockValid(const void* block, BlockType type) {
  const size_t begin = mappedBegin.load(std::memory_order_acquire);
  if (likely(size_t(block) - begin >= mappedBytes.load(std::memory_order_relaxed))) return true;
  /* Relaxed: while another thread maps the first file, this thread may see the range but no function yet. `block`
   * is then not mapped, because rays reach mapped blocks only after the commit of their scene. */
  const BlockValidator isValid = mappedBlockValidator.load(std::memory_order_relaxed);
  return !isValid || isValid(block, type);
}
} // namespace embree::cbvh
