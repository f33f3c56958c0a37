// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes bit fields into zeroed bytes, in any order: blocks of DGF are filled from both ends. */

#include "../portable/bits.h"
#include <cstddef>

namespace cvert {
/*! position: offset in bits. The `count` bits there must be zero. Higher bits of `value` are ignored. */
inline void writeBits(uint8_t* bytes, size_t position, uint32_t count, uint32_t value) {
  bytes += position / 8;
  for (uint64_t rest = uint64_t(value & uint32_t((uint64_t(1) << count) - 1)) << position % 8; rest; rest >>= 8)
    *bytes++ |= uint8_t(rest);
}

/*! Writes a word in little-endian order. */
inline void writeWord(uint8_t* bytes, uint32_t word) {
  for (int i = 0; i < 4; i++) bytes[i] = uint8_t(word >> 8 * i);
}
} // namespace cvert
