// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes bit fields. bitsAt() of bytes.h reads them. */

#include "language.h"
#include <cstdint>
#include <cstring>

namespace cvert { inline namespace CVERT_ISA {
/*! Number of bits that store a number; 0 for 0. */
inline uint32_t bitWidth(uint32_t number) { return number == 0 ? 0 : 32 - uint32_t(__builtin_clz(number)); }

/*! Appends fields of up to 32 bits without gaps, lowest bit first. Requires a little-endian processor. */
class BitWriter {
public:
  /*! out: of any alignment. */
  explicit BitWriter(uint8_t* out) : out(out) {}

  /*! Requires number < 2^bits. */
  void write(uint32_t number, uint32_t bits) {
    pending |= uint64_t(number) << count; // at most 31 pending bits and 32 new ones
    count += bits;
    if (count < 32) return;
    const uint32_t word = uint32_t(pending);
    std::memcpy(out, &word, sizeof(word));
    out += 4;
    pending >>= 32;
    count -= 32;
  }

  /*! Pads the last byte with zeros, and returns the end of the output. */
  uint8_t* finish() {
    for (; count > 0; count = count > 8 ? count - 8 : 0) {
      *out++ = uint8_t(pending);
      pending >>= 8;
    }
    return out;
  }

private:
  uint8_t* out;
  uint64_t pending = 0;
  uint32_t count = 0;
};
}} // namespace cvert::CVERT_ISA
