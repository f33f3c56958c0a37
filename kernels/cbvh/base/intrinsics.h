// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Intrinsics where Embree's vectors have no operation, and macros for their availability. Embree maps those of SSE4.1
 * to NEON (common/simd/arm). */

#include "../embree/simd.h"

/*! _mm_shuffle_epi8, _mm_mullo_epi32 and _mm_insert_epi32 */
#if defined(__SSE4_1__) || defined(__ARM_NEON)
#define CBVH_BYTE_SHUFFLES
#endif

/*! _mm_srlv_epi32 and _mm_sllv_epi32, where a count of 32 returns 0 */
#if defined(__AVX2__) || defined(__ARM_NEON)
#define CBVH_LANE_SHIFTS
#endif

#if defined(__ARM_NEON)
__forceinline __m128i _mm_sllv_epi32 (__m128i a, __m128i counts) { return vshlq_s32(a,counts); }
__forceinline __m128i _mm_srlv_epi32 (__m128i a, __m128i counts) {
  return vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a),vnegq_s32(counts)));
}
#endif

namespace embree
{
  /*! Shifts a left by one lane and inserts lane i of b last. On NEON, GCC would compile two-vector shuffles to table
   *  lookups. */
  template<int i>
  __forceinline __m128 shiftAndInsert (__m128 a, __m128 b)
  {
#if defined(__ARM_NEON)
    return vextq_f32(a,vdupq_laneq_f32(b,i),1);
#else
    return _mm_shuffle_ps(a,_mm_shuffle_ps(a,b,_MM_SHUFFLE(i,i,3,3)),_MM_SHUFFLE(2,0,2,1));
#endif
  }
}
