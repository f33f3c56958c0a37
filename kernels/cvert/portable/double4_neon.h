// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The functions of double4_avx.h in two NEON registers, with the same results, also for NaN. */

#include "lanes.h"

namespace cvert { inline namespace CVERT_ISA {
struct Mask4 {
  uint64x2_t v[2];

  uint32x4_t narrow() const { return vuzp1q_u32(vreinterpretq_u32_u64(v[0]), vreinterpretq_u32_u64(v[1])); }

  uint32_t bits() const { return maskBits(narrow()); }
  friend Mask4 operator&(Mask4 a, Mask4 b) { return {{vandq_u64(a.v[0], b.v[0]), vandq_u64(a.v[1], b.v[1])}}; }
  friend Mask4 operator|(Mask4 a, Mask4 b) { return {{vorrq_u64(a.v[0], b.v[0]), vorrq_u64(a.v[1], b.v[1])}}; }
};

struct Double4 {
  float64x2_t v[2];

  Double4() {}
  Double4(float64x2_t a, float64x2_t b) : v{a, b} {}
  Double4(double a) : v{vdupq_n_f64(a), vdupq_n_f64(a)} {}
  Double4(Float4 a) : v{vcvt_f64_f32(vget_low_f32(a.v)), vcvt_high_f64_f32(a.v)} {}
  Double4(double a, double b, double c, double d) : v{float64x2_t{a, b}, float64x2_t{c, d}} {}
  static Double4 load(const double* p) { return {vld1q_f64(p), vld1q_f64(p + 2)}; }
  void store(double* p) const {
    vst1q_f64(p, v[0]);
    vst1q_f64(p + 2, v[1]);
  }

  friend Double4 operator+(Double4 a, Double4 b) { return {vaddq_f64(a.v[0], b.v[0]), vaddq_f64(a.v[1], b.v[1])}; }
  friend Double4 operator-(Double4 a, Double4 b) { return {vsubq_f64(a.v[0], b.v[0]), vsubq_f64(a.v[1], b.v[1])}; }
  friend Double4 operator*(Double4 a, Double4 b) { return {vmulq_f64(a.v[0], b.v[0]), vmulq_f64(a.v[1], b.v[1])}; }
  friend Double4 operator/(Double4 a, Double4 b) { return {vdivq_f64(a.v[0], b.v[0]), vdivq_f64(a.v[1], b.v[1])}; }
  friend Mask4 operator<(Double4 a, Double4 b) { return {{vcltq_f64(a.v[0], b.v[0]), vcltq_f64(a.v[1], b.v[1])}}; }
  friend Mask4 operator<=(Double4 a, Double4 b) { return {{vcleq_f64(a.v[0], b.v[0]), vcleq_f64(a.v[1], b.v[1])}}; }
};

inline Double4 toDouble(Int4 a) {
  return {vcvtq_f64_s64(vmovl_s32(vget_low_s32(a.v))), vcvtq_f64_s64(vmovl_high_s32(a.v))};
}
inline Double4 abs(Double4 a) { return {vabsq_f64(a.v[0]), vabsq_f64(a.v[1])}; }
inline Double4 select(Mask4 m, Double4 a, Double4 b) {
  return {vbslq_f64(m.v[0], a.v[0], b.v[0]), vbslq_f64(m.v[1], a.v[1], b.v[1])};
}
inline Float4 toFloat(Double4 a) { return vcvt_high_f32_f64(vcvt_f32_f64(a.v[0]), a.v[1]); }

// vminq_f64 and vmaxq_f64 return NaN if any operand is
inline Double4 min(Double4 a, Double4 b) { return select(b < a, b, a); }
inline Double4 max(Double4 a, Double4 b) { return select(a < b, b, a); }

inline Double4 operator&(Mask4 m, Double4 a) {
  auto half = [&](int i) { return vreinterpretq_f64_u64(vandq_u64(m.v[i], vreinterpretq_u64_f64(a.v[i]))); };
  return {half(0), half(1)};
}

// vcvtq_s64_f64 saturates, and returns 0 for NaN
inline Int4 toInt(Double4 a) {
  auto half = [&](int i) {
    const int64x2_t whole = vcvtq_s64_f64(a.v[i]);
    const uint64x2_t fits =
        vandq_u64(vceqq_s64(whole, vmovl_s32(vmovn_s64(whole))), vceqq_f64(a.v[i], a.v[i])); // false for NaN
    return vmovn_s64(vbslq_s64(fits, whole, vdupq_n_s64(INT32_MIN)));
  };
  return vcombine_s32(half(0), half(1));
}
inline Int4 operator&(Mask4 m, Int4 a) { return vandq_s32(vreinterpretq_s32_u32(m.narrow()), a.v); }

inline Mask4 maskFromBits(uint32_t bits) {
  const int32x4_t set = vreinterpretq_s32_u32(vtstq_u32(vdupq_n_u32(bits), uint32x4_t{1, 2, 4, 8}));
  return {{vreinterpretq_u64_s64(vmovl_s32(vget_low_s32(set))), vreinterpretq_u64_s64(vmovl_high_s32(set))}};
}

inline double cross2D(Double4 a, Double4 b) {
  const float64x2_t p = vmulq_f64(a.v[0], vextq_f64(b.v[0], b.v[0], 1));
  return vgetq_lane_f64(p, 0) - vgetq_lane_f64(p, 1);
}

inline double reduceMin(Double4 a) {
  const float64x2_t m = vbslq_f64(vcltq_f64(a.v[0], a.v[1]), a.v[0], a.v[1]);
  return vgetq_lane_f64(m, 0) < vgetq_lane_f64(m, 1) ? vgetq_lane_f64(m, 0) : vgetq_lane_f64(m, 1);
}
inline double reduceMax(Double4 a) {
  const float64x2_t m = vbslq_f64(vcgtq_f64(a.v[0], a.v[1]), a.v[0], a.v[1]);
  return vgetq_lane_f64(m, 0) > vgetq_lane_f64(m, 1) ? vgetq_lane_f64(m, 0) : vgetq_lane_f64(m, 1);
}

template<int i> inline Double4 broadcast(Double4 a) {
  const float64x2_t lane = vdupq_laneq_f64(a.v[i / 2], i & 1);
  return {lane, lane};
}
}} // namespace cvert::CVERT_ISA
