// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Macros for intrinsics that not all instruction sets provide, and functions that Embree's vector types lack. On
 * ARM64, Embree implements the intrinsics of SSE4.1 with NEON (common/simd/arm). */

#include "../embree/simd.h"
#include <cstdint>
#include <cstring>

/*! _mm_shuffle_epi8, _mm_mullo_epi32 and _mm_insert_epi32 are available. */
#if defined(__SSE4_1__) || defined(__ARM_NEON)
#define CBVH_SSE41_INTEGERS
#endif

/*! _mm_srlv_epi32 and _mm_sllv_epi32 are available. They shift each lane by a count of its own, and return 0 for a
 *  count of 32. */
#if defined(__AVX2__) || defined(__ARM_NEON)
#define CBVH_VARIABLE_SHIFTS
#endif

#if defined(__ARM_NEON)
__forceinline __m128i _mm_sllv_epi32(__m128i a, __m128i counts) { return vshlq_s32(a, counts); }
__forceinline __m128i _mm_srlv_epi32(__m128i a, __m128i counts) {
  return vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a), vnegq_s32(counts)));
}
#endif

namespace embree {
/*! Returns lanes 1, 2 and 3 of a, followed by lane i of b. NEON uses vextq, because GCC compiles its shuffles of two
 *  vectors to table lookups. */
template<int i>
__forceinline __m128 dropFirstAndAppend(__m128 a, __m128 b) {
#if defined(__ARM_NEON)
  return vextq_f32(a, vdupq_laneq_f32(b, i), 1);
#else
  return _mm_shuffle_ps(a, _mm_shuffle_ps(a, b, _MM_SHUFFLE(i, i, 3, 3)), _MM_SHUFFLE(2, 0, 2, 1));
#endif
}

/*! Extends the lower 8 or 16 bits of each of the first lanes with zeros, to 32 bits. */
__forceinline __m128i extend16(__m128i x) { return _mm_unpacklo_epi16(x, _mm_setzero_si128()); }
__forceinline __m128i extend8(__m128i x) {
#if defined(__SSE4_1__)
  return _mm_cvtepu8_epi32(x);
#else
  return extend16(_mm_unpacklo_epi8(x, _mm_setzero_si128()));
#endif
}

/*! Loads 4 bytes, which need not be aligned. */
__forceinline __m128i loadFour(const uint8_t* p) {
  int bits;
  memcpy(&bits, p, sizeof(bits));
  return _mm_cvtsi32_si128(bits);
}

/*! Concatenates masks of at most 32 lanes in total: bit Mask::size*j + i of the result is lane i of masks[j]. */
template<typename Mask, int n>
__forceinline uint32_t movemasks(const Mask (&masks)[n]) {
  uint32_t lanes = 0;
  for (int j = 0; j < n; j++) lanes |= uint32_t(movemask(masks[j])) << (Mask::size * j);
  return lanes;
}

#if !defined(__AVX__) // with AVX, callers have masks of 8 or 16 lanes
/*! As above, for 16 lanes. Packs the masks to bytes first, because collecting bits requires several instructions of
 *  NEON. */
__forceinline uint32_t movemasks(const vboolf4 (&masks)[4]) {
#if defined(__ARM_NEON)
  auto as16Bits = [&](int j) { return vreinterpretq_u16_u32(vreinterpretq_u32_f32(masks[j])); };
  const uint8x16_t bytes = vuzp1q_u8(vreinterpretq_u8_u16(vuzp1q_u16(as16Bits(0), as16Bits(1))),
                                     vreinterpretq_u8_u16(vuzp1q_u16(as16Bits(2), as16Bits(3))));
  static const uint8x16_t bits = {1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128};
  uint8x16_t sums = vandq_u8(bytes, bits);
  for (int i = 0; i < 3; i++) sums = vpaddq_u8(sums, sums);
  return vgetq_lane_u16(vreinterpretq_u16_u8(sums), 0);
#else
  auto pack = [&](int j) { return _mm_packs_epi32(_mm_castps_si128(masks[j]), _mm_castps_si128(masks[j + 1])); };
  return uint32_t(_mm_movemask_epi8(_mm_packs_epi16(pack(0), pack(2))));
#endif
}
#endif
} // namespace embree
