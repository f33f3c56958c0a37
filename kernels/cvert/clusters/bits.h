// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes numbers of a few bits into bytes that are zero, in any order. The lowest bits of the first byte come first. */

#include "../basics/bits.h"
#include <cstddef>

namespace cvert
{
  /*! Writes `count` bits of value at a position in bits. The bytes must be zero there. */
  inline void putBits (uint8_t* bytes, size_t position, uint32_t count, uint32_t value)
  {
    bytes += position/8;
    for (uint64_t rest=uint64_t(value & uint32_t((uint64_t(1) << count)-1)) << position%8; rest; rest>>=8)
      *bytes++ |= uint8_t(rest);
  }

  inline void putWord (uint8_t* bytes, uint32_t word) {
    for (int i=0; i<4; i++) bytes[i] = uint8_t(word >> 8*i);
  }
}
