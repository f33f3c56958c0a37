// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The functions of double4_avx.h in two SSE2 registers, for processors without AVX. */

#include "lanes.h"

namespace cvert { inline namespace CVERT_ISA {
struct Mask4 {
  __m128d v[2];

  uint32_t bits() const { return uint32_t(_mm_movemask_pd(v[0]) | _mm_movemask_pd(v[1]) << 2); }
  friend Mask4 operator&(Mask4 a, Mask4 b) { return {{_mm_and_pd(a.v[0], b.v[0]), _mm_and_pd(a.v[1], b.v[1])}}; }
  friend Mask4 operator|(Mask4 a, Mask4 b) { return {{_mm_or_pd(a.v[0], b.v[0]), _mm_or_pd(a.v[1], b.v[1])}}; }
};

struct Double4 {
  __m128d v[2];

  Double4() {}
  Double4(__m128d a, __m128d b) : v{a, b} {}
  Double4(double a) : v{_mm_set1_pd(a), _mm_set1_pd(a)} {}
  Double4(Float4 a) : v{_mm_cvtps_pd(a.v), _mm_cvtps_pd(_mm_movehl_ps(a.v, a.v))} {}
  Double4(double a, double b, double c, double d) : v{_mm_setr_pd(a, b), _mm_setr_pd(c, d)} {}
  static Double4 load(const double* p) { return {_mm_loadu_pd(p), _mm_loadu_pd(p + 2)}; }
  void store(double* p) const {
    _mm_storeu_pd(p, v[0]);
    _mm_storeu_pd(p + 2, v[1]);
  }

  friend Double4 operator+(Double4 a, Double4 b) { return {_mm_add_pd(a.v[0], b.v[0]), _mm_add_pd(a.v[1], b.v[1])}; }
  friend Double4 operator-(Double4 a, Double4 b) { return {_mm_sub_pd(a.v[0], b.v[0]), _mm_sub_pd(a.v[1], b.v[1])}; }
  friend Double4 operator*(Double4 a, Double4 b) { return {_mm_mul_pd(a.v[0], b.v[0]), _mm_mul_pd(a.v[1], b.v[1])}; }
  friend Double4 operator/(Double4 a, Double4 b) { return {_mm_div_pd(a.v[0], b.v[0]), _mm_div_pd(a.v[1], b.v[1])}; }
  friend Mask4 operator<(Double4 a, Double4 b) {
    return {{_mm_cmplt_pd(a.v[0], b.v[0]), _mm_cmplt_pd(a.v[1], b.v[1])}};
  }
  friend Mask4 operator<=(Double4 a, Double4 b) {
    return {{_mm_cmple_pd(a.v[0], b.v[0]), _mm_cmple_pd(a.v[1], b.v[1])}};
  }
};

inline Double4 toDouble(Int4 a) { return {_mm_cvtepi32_pd(a.v), _mm_cvtepi32_pd(_mm_unpackhi_epi64(a.v, a.v))}; }
inline Double4 min(Double4 a, Double4 b) { return {_mm_min_pd(b.v[0], a.v[0]), _mm_min_pd(b.v[1], a.v[1])}; }
inline Double4 max(Double4 a, Double4 b) { return {_mm_max_pd(b.v[0], a.v[0]), _mm_max_pd(b.v[1], a.v[1])}; }
inline Double4 abs(Double4 a) {
  return {_mm_andnot_pd(_mm_set1_pd(-0.0), a.v[0]), _mm_andnot_pd(_mm_set1_pd(-0.0), a.v[1])};
}
inline Double4 select(Mask4 m, Double4 a, Double4 b) {
  return {_mm_or_pd(_mm_and_pd(m.v[0], a.v[0]), _mm_andnot_pd(m.v[0], b.v[0])),
          _mm_or_pd(_mm_and_pd(m.v[1], a.v[1]), _mm_andnot_pd(m.v[1], b.v[1]))};
}
inline Float4 toFloat(Double4 a) { return _mm_movelh_ps(_mm_cvtpd_ps(a.v[0]), _mm_cvtpd_ps(a.v[1])); }
inline Double4 operator&(Mask4 m, Double4 a) { return {_mm_and_pd(m.v[0], a.v[0]), _mm_and_pd(m.v[1], a.v[1])}; }
inline Int4 toInt(Double4 a) { return _mm_unpacklo_epi64(_mm_cvttpd_epi32(a.v[0]), _mm_cvttpd_epi32(a.v[1])); }
inline Int4 operator&(Mask4 m, Int4 a) {
  return _mm_and_si128(
      _mm_castps_si128(_mm_shuffle_ps(_mm_castpd_ps(m.v[0]), _mm_castpd_ps(m.v[1]), _MM_SHUFFLE(2, 0, 2, 0))), a.v);
}
inline Mask4 maskFromBits(uint32_t bits) {
  const __m128i lanes = _mm_and_si128(_mm_set1_epi32(int(bits)), _mm_setr_epi32(1, 2, 4, 8)),
                set = _mm_cmpgt_epi32(lanes, _mm_setzero_si128());
  return {{_mm_castsi128_pd(_mm_unpacklo_epi32(set, set)), _mm_castsi128_pd(_mm_unpackhi_epi32(set, set))}};
}
inline double cross2D(Double4 a, Double4 b) {
  const __m128d p = _mm_mul_pd(a.v[0], _mm_shuffle_pd(b.v[0], b.v[0], 1));
  return _mm_cvtsd_f64(_mm_sub_sd(p, _mm_unpackhi_pd(p, p)));
}
inline double reduceMin(Double4 a) {
  const __m128d m = _mm_min_pd(a.v[0], a.v[1]);
  return _mm_cvtsd_f64(_mm_min_sd(m, _mm_unpackhi_pd(m, m)));
}
inline double reduceMax(Double4 a) {
  const __m128d m = _mm_max_pd(a.v[0], a.v[1]);
  return _mm_cvtsd_f64(_mm_max_sd(m, _mm_unpackhi_pd(m, m)));
}
template<int i> inline Double4 broadcast(Double4 a) {
  const __m128d lane = i & 1 ? _mm_unpackhi_pd(a.v[i / 2], a.v[i / 2]) : _mm_unpacklo_pd(a.v[i / 2], a.v[i / 2]);
  return {lane, lane};
}
}} // namespace cvert::CVERT_ISA
