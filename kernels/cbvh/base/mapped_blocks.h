// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Blocks of a mapped file are checked before they are first decoded (files/mapped_blocks.h), because checking them on
 * opening would read the whole file. Code that reads more than a block's header must call isUsable first. */

#include "../embree/simd.h"
#include "primitive_type.h"
#include <atomic>
#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    /*! Range of addresses that contains all mapped blocks, possibly with other memory between them. Empty if there are
     *  none. Read mappedBegin before mappedBytes. */
    extern std::atomic<size_t> mappedBegin, mappedBytes;

    /*! Implements isUsable for this range. Null until a file is mapped. */
    extern std::atomic<bool (*) (const void* block, BlockForm form)> isMappedBlockValid;

    /*! True if a block may be decoded. If not, its surface is empty, and the device receives one error per geometry. */
    __forceinline bool isUsable (const void* block, BlockForm form)
    {
      const size_t begin = mappedBegin.load(std::memory_order_acquire);
      if (likely(size_t(block)-begin >= mappedBytes.load(std::memory_order_relaxed))) return true;
      /* Relaxed: a thread may see the range before the function while another maps the first file. It cannot trace a
       * mapped block then, because its rays come after the commit of a scene with one. */
      bool (*const isValid) (const void*, BlockForm) = isMappedBlockValid.load(std::memory_order_relaxed);
      return !isValid || isValid(block,form);
    }
  }
}
