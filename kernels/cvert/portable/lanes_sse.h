// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Four floats or integers in an SSE2 register. The other variants of lanes.h have the same functions with the same
 * results; this file documents them. */

#include "language.h"
#include <immintrin.h>
#include <cstddef>
#include <cstdint>

namespace cvert { inline namespace CVERT_ISA {
struct Float4 {
  __m128 v;

  Float4() {}
  Float4(__m128 v) : v(v) {}
  Float4(float a) : v(_mm_set1_ps(a)) {}
  Float4(float a, float b, float c, float d) : v(_mm_setr_ps(a, b, c, d)) {}
  static Float4 load(const float* p) { return _mm_loadu_ps(p); }
  void store(float* p) const { _mm_storeu_ps(p, v); }

  friend Float4 operator+(Float4 a, Float4 b) { return _mm_add_ps(a.v, b.v); }
  friend Float4 operator-(Float4 a, Float4 b) { return _mm_sub_ps(a.v, b.v); }
  friend Float4 operator*(Float4 a, Float4 b) { return _mm_mul_ps(a.v, b.v); }
};

/* Return the first operand if an operand is NaN, as std::min and std::max do. */
inline Float4 min(Float4 a, Float4 b) { return _mm_min_ps(b.v, a.v); }
inline Float4 max(Float4 a, Float4 b) { return _mm_max_ps(b.v, a.v); }

inline Float4 abs(Float4 a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a.v); }

/*! Mask of the lanes in which a is less than b. */
inline Float4 lessThan(Float4 a, Float4 b) { return _mm_cmplt_ps(a.v, b.v); }
inline Float4 operator&(Float4 mask, Float4 a) { return _mm_and_ps(mask.v, a.v); }
inline Float4 select(Float4 mask, Float4 a, Float4 b) {
  return _mm_or_ps(_mm_and_ps(mask.v, a.v), _mm_andnot_ps(mask.v, b.v));
}

inline float reduceMax(Float4 a) {
  const __m128 m = _mm_max_ps(a.v, _mm_movehl_ps(a.v, a.v));
  return _mm_cvtss_f32(_mm_max_ss(m, _mm_shuffle_ps(m, m, 1)));
}

/* Return a bit per lane; bit i is lane i. */
inline uint32_t lessThanBits(Float4 a, Float4 b) { return uint32_t(_mm_movemask_ps(_mm_cmplt_ps(a.v, b.v))); }
inline uint32_t equalBits(Float4 a, Float4 b) { return uint32_t(_mm_movemask_ps(_mm_cmpeq_ps(a.v, b.v))); }

struct Int4 {
  __m128i v;

  Int4() {}
  Int4(__m128i v) : v(v) {}
  Int4(int a) : v(_mm_set1_epi32(a)) {}
  static Int4 load(const uint32_t* p) { return _mm_loadu_si128((const __m128i*)p); }
  static Int4 load(const int* p) { return _mm_loadu_si128((const __m128i*)p); }
  void store(uint32_t* p) const { _mm_storeu_si128((__m128i*)p, v); }
  void store(int* p) const { _mm_storeu_si128((__m128i*)p, v); }

  friend Int4 operator+(Int4 a, Int4 b) { return _mm_add_epi32(a.v, b.v); }
  friend Int4 operator-(Int4 a, Int4 b) { return _mm_sub_epi32(a.v, b.v); }
  friend Int4 operator|(Int4 a, Int4 b) { return _mm_or_si128(a.v, b.v); }
  friend Int4 operator&(Int4 a, Int4 b) { return _mm_and_si128(a.v, b.v); }
  friend Int4 operator^(Int4 a, Int4 b) { return _mm_xor_si128(a.v, b.v); }
  /* A shift by 32 returns 0. Right shifts fill with zeros; shiftArithmetic fills with the sign. */
  friend Int4 operator<<(Int4 a, int n) { return _mm_slli_epi32(a.v, n); }
  friend Int4 operator>>(Int4 a, int n) { return _mm_srli_epi32(a.v, n); }
};

inline Int4 shiftArithmetic(Int4 a, int n) { return _mm_srai_epi32(a.v, n); }

/*! Returns the lower 32 bits of each product. */
inline Int4 operator*(Int4 a, Int4 b) {
#if defined(__SSE4_1__)
  return _mm_mullo_epi32(a.v, b.v);
#else
  const __m128i even = _mm_mul_epu32(a.v, b.v), odd = _mm_mul_epu32(_mm_srli_epi64(a.v, 32), _mm_srli_epi64(b.v, 32));
  return _mm_unpacklo_epi32(_mm_shuffle_epi32(even, _MM_SHUFFLE(0, 0, 2, 0)),
                            _mm_shuffle_epi32(odd, _MM_SHUFFLE(0, 0, 2, 0)));
#endif
}

#if defined(__SSE4_1__)
inline Int4 min(Int4 a, Int4 b) { return _mm_min_epi32(a.v, b.v); }
inline Int4 max(Int4 a, Int4 b) { return _mm_max_epi32(a.v, b.v); }
#else
inline Int4 lessThan(Int4 a, Int4 b) { return _mm_cmplt_epi32(a.v, b.v); }
inline Int4 select(Int4 mask, Int4 a, Int4 b) {
  return _mm_or_si128(_mm_and_si128(mask.v, a.v), _mm_andnot_si128(mask.v, b.v));
}
inline Int4 min(Int4 a, Int4 b) { return select(lessThan(a, b), a, b); }
inline Int4 max(Int4 a, Int4 b) { return select(lessThan(a, b), b, a); }
#endif

/*! Combines all lanes by an operation that is associative and commutative. */
template<typename Operation>
inline int reduce(Int4 a, const Operation& operation) {
  const Int4 halves = operation(a, Int4(_mm_shuffle_epi32(a.v, _MM_SHUFFLE(1, 0, 3, 2))));
  return _mm_cvtsi128_si32(operation(halves, Int4(_mm_shuffle_epi32(halves.v, 1))).v);
}
inline int reduceMin(Int4 a) {
  return reduce(a, [](Int4 x, Int4 y) { return min(x, y); });
}
inline int reduceMax(Int4 a) {
  return reduce(a, [](Int4 x, Int4 y) { return max(x, y); });
}
inline int reduceOr(Int4 a) {
  return reduce(a, [](Int4 x, Int4 y) { return x | y; });
}

/*! Requires lanes from 0 to 255. */
inline Int4 square(Int4 a) { return _mm_mullo_epi16(a.v, a.v); }
inline Float4 toFloat(Int4 a) { return _mm_cvtepi32_ps(a.v); }

/*! Rounds towards zero. Returns INT32_MIN for NaN and numbers out of range. */
inline Int4 truncateToInt(Float4 a) { return _mm_cvttps_epi32(a.v); }

/*! Rounds to nearest, halves to even. Returns any integer for NaN and numbers out of range. */
inline Int4 roundToInt(Float4 a) { return _mm_cvtps_epi32(a.v); }
inline int roundToInt(float a) { return _mm_cvtss_si32(_mm_set_ss(a)); }

/*! Splits four vertices by axis. a, b, c: x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3. */
inline void deinterleave(Float4 a, Float4 b, Float4 c, Float4& x, Float4& y, Float4& z) {
  const __m128 yz = _mm_shuffle_ps(a.v, b.v, _MM_SHUFFLE(1, 0, 2, 1)), // of the first two vertices
      xy = _mm_shuffle_ps(b.v, c.v, _MM_SHUFFLE(2, 1, 3, 2));          // of the last two
  x = _mm_shuffle_ps(a.v, xy, _MM_SHUFFLE(2, 0, 3, 0));
  y = _mm_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0));
  z = _mm_shuffle_ps(yz, c.v, _MM_SHUFFLE(3, 0, 3, 1));
}
}} // namespace cvert::CVERT_ISA
