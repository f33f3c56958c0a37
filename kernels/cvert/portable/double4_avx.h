// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Four doubles in an AVX register. The comments here document the functions of all variants of double4.h. */

#include "lanes.h"

namespace cvert { inline namespace CVERT_ISA {
struct Mask4 {
  __m256d v;

  uint32_t bits() const { return uint32_t(_mm256_movemask_pd(v)); }
  friend Mask4 operator&(Mask4 a, Mask4 b) { return {_mm256_and_pd(a.v, b.v)}; }
  friend Mask4 operator|(Mask4 a, Mask4 b) { return {_mm256_or_pd(a.v, b.v)}; }
};

struct Double4 {
  __m256d v;

  Double4() {}
  Double4(__m256d v) : v(v) {}
  Double4(double a) : v(_mm256_set1_pd(a)) {}
  Double4(Float4 a) : v(_mm256_cvtps_pd(a.v)) {}
  Double4(double a, double b, double c, double d) : v(_mm256_setr_pd(a, b, c, d)) {}
  static Double4 load(const double* p) { return _mm256_loadu_pd(p); }
  void store(double* p) const { _mm256_storeu_pd(p, v); }

  friend Double4 operator+(Double4 a, Double4 b) { return _mm256_add_pd(a.v, b.v); }
  friend Double4 operator-(Double4 a, Double4 b) { return _mm256_sub_pd(a.v, b.v); }
  friend Double4 operator*(Double4 a, Double4 b) { return _mm256_mul_pd(a.v, b.v); }
  friend Double4 operator/(Double4 a, Double4 b) { return _mm256_div_pd(a.v, b.v); }
  friend Mask4 operator<(Double4 a, Double4 b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LT_OQ)}; }
  friend Mask4 operator<=(Double4 a, Double4 b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LE_OQ)}; }
};

inline Double4 toDouble(Int4 a) { return _mm256_cvtepi32_pd(a.v); }

/* Return the first operand if both are equal or one is NaN. */
inline Double4 min(Double4 a, Double4 b) { return _mm256_min_pd(b.v, a.v); }
inline Double4 max(Double4 a, Double4 b) { return _mm256_max_pd(b.v, a.v); }

inline Double4 abs(Double4 a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a.v); }
inline Double4 select(Mask4 m, Double4 a, Double4 b) { return _mm256_blendv_pd(b.v, a.v, m.v); }
inline Float4 toFloat(Double4 a) { return _mm256_cvtpd_ps(a.v); }

/*! Sets lanes to 0 where the mask is not set. */
inline Double4 operator&(Mask4 m, Double4 a) { return _mm256_and_pd(m.v, a.v); }

/*! Rounds towards zero. Returns INT32_MIN for NaN and numbers out of range. */
inline Int4 toInt(Double4 a) { return _mm256_cvttpd_epi32(a.v); }

inline Int4 operator&(Mask4 m, Int4 a) {
  const __m128 low = _mm_castpd_ps(_mm256_castpd256_pd128(m.v)), high = _mm_castpd_ps(_mm256_extractf128_pd(m.v, 1));
  return _mm_and_si128(_mm_castps_si128(_mm_shuffle_ps(low, high, _MM_SHUFFLE(2, 0, 2, 0))), a.v);
}

/*! Converts bit i of `bits` to the mask of lane i. */
inline Mask4 maskFromBits(uint32_t bits) {
  const __m128i lanes = _mm_and_si128(_mm_set1_epi32(int(bits)), _mm_setr_epi32(1, 2, 4, 8)),
                set = _mm_cmpgt_epi32(lanes, _mm_setzero_si128());
  return {_mm256_castsi256_pd(
      _mm256_insertf128_si256(_mm256_castsi128_si256(_mm_unpacklo_epi32(set, set)), _mm_unpackhi_epi32(set, set), 1))};
}

/*! Returns a0 b1 - a1 b0, the z component of a cross product. */
inline double cross2D(Double4 a, Double4 b) {
  const __m128d l = _mm256_castpd256_pd128(b.v), p = _mm_mul_pd(_mm256_castpd256_pd128(a.v), _mm_shuffle_pd(l, l, 1));
  return _mm_cvtsd_f64(_mm_sub_sd(p, _mm_unpackhi_pd(p, p)));
}

inline double reduceMin(Double4 a) {
  const __m128d m = _mm_min_pd(_mm256_castpd256_pd128(a.v), _mm256_extractf128_pd(a.v, 1));
  return _mm_cvtsd_f64(_mm_min_sd(m, _mm_unpackhi_pd(m, m)));
}
inline double reduceMax(Double4 a) {
  const __m128d m = _mm_max_pd(_mm256_castpd256_pd128(a.v), _mm256_extractf128_pd(a.v, 1));
  return _mm_cvtsd_f64(_mm_max_sd(m, _mm_unpackhi_pd(m, m)));
}

template<int i> inline Double4 broadcast(Double4 a) {
  const __m128d half = i < 2 ? _mm256_castpd256_pd128(a.v) : _mm256_extractf128_pd(a.v, 1);
  const __m128d lane = i & 1 ? _mm_unpackhi_pd(half, half) : _mm_unpacklo_pd(half, half);
  return _mm256_insertf128_pd(_mm256_castpd128_pd256(lane), lane, 1);
}
}} // namespace cvert::CVERT_ISA
