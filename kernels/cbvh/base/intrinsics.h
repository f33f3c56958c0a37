// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Intrinsics where Embree's vectors have no operation, and which of them an instruction set has. Embree maps those of
 * SSE4.1 to NEON (common/simd/arm). */

#include "../embree/simd.h"

/*! _mm_shuffle_epi8, _mm_mullo_epi32 and _mm_insert_epi32 */
#if defined(__SSE4_1__) || defined(__ARM_NEON)
#define CBVH_BYTE_SHUFFLES
#endif

/*! _mm_srlv_epi32 and _mm_sllv_epi32: shifts by a count per lane, where 32 makes 0 */
#if defined(__AVX2__) || defined(__ARM_NEON)
#define CBVH_LANE_SHIFTS
#endif

#if defined(__ARM_NEON)
__forceinline __m128i _mm_sllv_epi32 (__m128i a, __m128i counts) { return vshlq_s32(a,counts); }
__forceinline __m128i _mm_srlv_epi32 (__m128i a, __m128i counts) {
  return vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a),vnegq_s32(counts)));
}
#endif
