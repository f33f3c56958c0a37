// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reads arrays of bit fields of the same size, a field per lane, by a table of byte shuffles. */

#include "../base/intrinsics.h"
#include "../base/vectors.h"

namespace embree::isa::cbvh {
static const uint32_t maxPackedFieldBits = 16;
static const uint32_t packedFieldReadBytes = 16; //!< bytes from the first of eight fields on that are read

/*! How to read eight fields from 16 bytes, by their number of bits. */
struct PackedFieldTable {
  alignas(32) uint8_t bytes[maxPackedFieldBits + 1][8][4]; //!< the field's bytes; 0x80 for none
  alignas(32) uint32_t shifts[maxPackedFieldBits + 1][8];  //!< lower bits that precede the field
  alignas(32) int factors[maxPackedFieldBits + 1][8];      //!< 2^(7-shift)

  constexpr PackedFieldTable() : bytes(), shifts(), factors() {
    for (uint32_t bits = 0; bits <= maxPackedFieldBits; bits++)
      for (uint32_t i = 0; i < 8; i++) {
        const uint32_t first = i * bits / 8;
        for (uint32_t j = 0; j < 4; j++) bytes[bits][i][j] = uint8_t(first + j < 16 ? first + j : 0x80);
        shifts[bits][i] = i * bits % 8;
        factors[bits][i] = 1 << (7 - i * bits % 8);
      }
  }
};
static constexpr PackedFieldTable packedFieldTable;

/*! Fields n to n+vectorWidth-1 of an array; higher bits of a lane are undefined. n: a multiple of vectorWidth. Reads
 *  packedFieldReadBytes from every eighth field on. */
__forceinline vintV loadPackedFields(const uint8_t* array, uint32_t bits, uint32_t n) {
  const uint8_t* const first = array + (n >> 3) * bits;
#if defined(__AVX512F__)
  const __m512i words =
      _mm512_inserti64x4(_mm512_castsi256_si512(_mm256_broadcastsi128_si256(_mm_loadu_si128((const __m128i*)first))),
                         _mm256_broadcastsi128_si256(_mm_loadu_si128((const __m128i*)(first + bits))), 1);
  const __m512i bytes = _mm512_broadcast_i64x4(_mm256_load_si256((const __m256i*)packedFieldTable.bytes[bits])),
                shifts = _mm512_broadcast_i64x4(_mm256_load_si256((const __m256i*)packedFieldTable.shifts[bits]));
  return vintV(_mm512_srlv_epi32(_mm512_shuffle_epi8(words, bytes), shifts));
#elif defined(__AVX2__)
  const __m256i words = _mm256_broadcastsi128_si256(_mm_loadu_si128((const __m128i*)first));
  return vintV(
      _mm256_srlv_epi32(_mm256_shuffle_epi8(words, _mm256_load_si256((const __m256i*)packedFieldTable.bytes[bits])),
                        _mm256_load_si256((const __m256i*)packedFieldTable.shifts[bits])));
#else
  auto four = [&](uint32_t i) { // fields i to i+3 of eight
#if defined(CBVH_SSE41_INTEGERS)
    const __m128i words = _mm_shuffle_epi8(_mm_loadu_si128((const __m128i*)first),
                                           _mm_load_si128((const __m128i*)packedFieldTable.bytes[bits][i]));
    return _mm_srli_epi32(_mm_mullo_epi32(words, _mm_load_si128((const __m128i*)(packedFieldTable.factors[bits] + i))),
                          7);
#else
    uint64_t halves[2];
    memcpy(halves, first, sizeof(halves));
    auto field = [&](uint32_t at) {
      const uint32_t bit = at * bits;
      return int(
          bit<48 ? halves[0] >> bit : bit<64 ? halves[0] >> bit | halves[1] << (64 - bit) : halves[1]>>(bit - 64));
    };
    return _mm_setr_epi32(field(i), field(i + 1), field(i + 2), field(i + 3));
#endif
  };
#if defined(__AVX__)
  return vintV(vint4(four(0)), vint4(four(4)));
#else
  return vintV(four(n & 4u));
#endif
#endif
}
} // namespace embree::isa::cbvh
