// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Blocks that lie in a mapped file. Nobody looked at them when the file was opened, as that would fetch all of it: each is checked before it
 * is decoded first, by whoever decodes it (files/mapped_blocks.h). Decoders and all who read more of a block than its header ask here. */

#include "../embree/simd.h"
#include "primitive_type.h"
#include <atomic>
#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    /*! Addresses that hold all blocks that are mapped, and others; no bytes where none are. To be read in this order. */
    extern std::atomic<size_t> mappedBegin, mappedBytes;

    /*! The same as isUsable, of a block between those addresses; null until a file is mapped. */
    extern std::atomic<bool (*) (const void* block, BlockForm form)> isMappedBlockGood;

    /*! Whether a block may be decoded. Of one that may not the device was told, once for its geometry; it has no surface. */
    __forceinline bool isUsable (const void* block, BlockForm form)
    {
      const size_t begin = mappedBegin.load(std::memory_order_acquire);
      if (likely(size_t(block)-begin >= mappedBytes.load(std::memory_order_relaxed))) return true;
      /* Relaxed loads: while another thread maps the first file, the addresses may be seen before the function. A thread
       * that sees none traces no mapped block: the commit of a scene that has one comes before its rays. */
      bool (*const isGood) (const void*, BlockForm) = isMappedBlockGood.load(std::memory_order_relaxed);
      return !isGood || isGood(block,form);
    }
  }
}
