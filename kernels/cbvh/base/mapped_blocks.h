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
    /*! Addresses that hold all blocks that are mapped, and others; no bytes where none are. To be read in this order, each with
     *  acquire: a thread that finds new addresses must find the function, which is stored before them. */
    extern std::atomic<size_t> mappedBegin, mappedBytes;

    /*! The same as isUsable, of a block between those addresses. */
    extern std::atomic<bool (*) (const void* block, BlockForm form)> isMappedBlockGood;

    /*! Whether a block may be decoded. Of one that may not the device was told, once for its geometry; it has no surface. */
    __forceinline bool isUsable (const void* block, BlockForm form)
    {
      const size_t begin = mappedBegin.load(std::memory_order_acquire);
      return likely(size_t(block)-begin >= mappedBytes.load(std::memory_order_acquire)) || isMappedBlockGood.load(std::memory_order_relaxed)(block,form);
    }
  }
}
