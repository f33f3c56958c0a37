// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The functions of lanes_sse.h in NEON registers. */

#include "language.h"
#include <arm_neon.h>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace cvert { inline namespace CVERT_ISA {
struct Float4 {
  float32x4_t v;

  Float4() {}
  Float4(float32x4_t v) : v(v) {}
  Float4(float a) : v(vdupq_n_f32(a)) {}
  Float4(float a, float b, float c, float d) : v(float32x4_t{a, b, c, d}) {}
  static Float4 load(const float* p) { return vld1q_f32(p); }
  void store(float* p) const { vst1q_f32(p, v); }

  friend Float4 operator+(Float4 a, Float4 b) { return vaddq_f32(a.v, b.v); }
  friend Float4 operator-(Float4 a, Float4 b) { return vsubq_f32(a.v, b.v); }
  friend Float4 operator*(Float4 a, Float4 b) { return vmulq_f32(a.v, b.v); }
};

/*! In each lane, all bits are set or none. */
struct FloatMask4 {
  uint32x4_t v;
};

inline FloatMask4 lessThan(Float4 a, Float4 b) { return {vcltq_f32(a.v, b.v)}; }
inline Float4 operator&(FloatMask4 mask, Float4 a) {
  return vreinterpretq_f32_u32(vandq_u32(mask.v, vreinterpretq_u32_f32(a.v)));
}
inline Float4 select(FloatMask4 mask, Float4 a, Float4 b) { return vbslq_f32(mask.v, a.v, b.v); }

/* Return the first operand if an operand is NaN, as std::min and std::max do. NEON's instructions return NaN. */
inline Float4 min(Float4 a, Float4 b) { return select(lessThan(b, a), b, a); }
inline Float4 max(Float4 a, Float4 b) { return select(lessThan(a, b), b, a); }

inline Float4 abs(Float4 a) { return vabsq_f32(a.v); }

inline float reduceMax(Float4 a) {
  const Float4 m = max(vextq_f32(a.v, a.v, 2), a);
  const float m0 = vgetq_lane_f32(m.v, 0), m1 = vgetq_lane_f32(m.v, 1);
  return m0 > m1 ? m0 : m1;
}

inline uint32_t maskBits(uint32x4_t mask) { return vaddvq_u32(vandq_u32(mask, uint32x4_t{1, 2, 4, 8})); }

inline uint32_t lessThanBits(Float4 a, Float4 b) { return maskBits(vcltq_f32(a.v, b.v)); }
inline uint32_t equalBits(Float4 a, Float4 b) { return maskBits(vceqq_f32(a.v, b.v)); }

struct Int4 {
  int32x4_t v;

  Int4() {}
  Int4(int32x4_t v) : v(v) {}
  Int4(int a) : v(vdupq_n_s32(a)) {}
  static Int4 load(const uint32_t* p) { return vreinterpretq_s32_u32(vld1q_u32(p)); }
  static Int4 load(const int* p) { return vld1q_s32(p); }
  void store(uint32_t* p) const { vst1q_u32(p, vreinterpretq_u32_s32(v)); }
  void store(int* p) const { vst1q_s32(p, v); }

  friend Int4 operator+(Int4 a, Int4 b) { return vaddq_s32(a.v, b.v); }
  friend Int4 operator-(Int4 a, Int4 b) { return vsubq_s32(a.v, b.v); }
  friend Int4 operator*(Int4 a, Int4 b) { return vmulq_s32(a.v, b.v); }
  friend Int4 operator|(Int4 a, Int4 b) { return vorrq_s32(a.v, b.v); }
  friend Int4 operator&(Int4 a, Int4 b) { return vandq_s32(a.v, b.v); }
  friend Int4 operator^(Int4 a, Int4 b) { return veorq_s32(a.v, b.v); }

  /* A shift by 32 returns 0, as in SSE2. */
  friend Int4 operator<<(Int4 a, int n) { return vshlq_s32(a.v, vdupq_n_s32(n)); }
  friend Int4 operator>>(Int4 a, int n) {
    return vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a.v), vdupq_n_s32(-n)));
  }
};

inline Int4 shiftArithmetic(Int4 a, int n) { return vshlq_s32(a.v, vdupq_n_s32(-n)); }

inline Int4 min(Int4 a, Int4 b) { return vminq_s32(a.v, b.v); }
inline Int4 max(Int4 a, Int4 b) { return vmaxq_s32(a.v, b.v); }

inline int reduceMin(Int4 a) { return vminvq_s32(a.v); }
inline int reduceMax(Int4 a) { return vmaxvq_s32(a.v); }
inline int reduceOr(Int4 a) {
  const int64x2_t halves = vreinterpretq_s64_s32(a.v);
  const uint64_t both = uint64_t(vgetq_lane_s64(halves, 0) | vgetq_lane_s64(halves, 1));
  return int(uint32_t(both | both >> 32));
}

inline Int4 square(Int4 a) { return vmulq_s32(a.v, a.v); }
inline Float4 toFloat(Int4 a) { return vcvtq_f32_s32(a.v); }

/* NEON's conversion would saturate instead of returning INT32_MIN. */
inline Int4 truncateToInt(Float4 a) {
  return vbslq_s32(vcltq_f32(vabsq_f32(a.v), vdupq_n_f32(2147483648.0f)), vcvtq_s32_f32(a.v), vdupq_n_s32(INT32_MIN));
}

inline Int4 roundToInt(Float4 a) { return vcvtnq_s32_f32(a.v); }
inline int roundToInt(float a) { return std::fabs(a) < 2147483648.0f ? vcvtns_s32_f32(a) : INT32_MIN; }

inline void deinterleave(Float4 a, Float4 b, Float4 c, Float4& x, Float4& y, Float4& z) {
  auto pick = [](Float4 low, Float4 high, const uint8x16_t& bytes) {
    return vreinterpretq_f32_u8(
        vqtbl2q_u8(uint8x16x2_t{{vreinterpretq_u8_f32(low.v), vreinterpretq_u8_f32(high.v)}}, bytes));
  };
  const Float4 xy = pick(b, c, uint8x16_t{8, 9, 10, 11, 12, 13, 14, 15, 20, 21, 22, 23, 24, 25, 26, 27}); // x2 y2 x3 y3
  x = pick(a, xy, uint8x16_t{0, 1, 2, 3, 12, 13, 14, 15, 16, 17, 18, 19, 24, 25, 26, 27});
  const Float4 yz = vextq_f32(a.v, b.v, 1); // y0 z0 x1 y1
  y = pick(yz, xy, uint8x16_t{0, 1, 2, 3, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31});
  const Float4 z01 = pick(a, b, uint8x16_t{8, 9, 10, 11, 20, 21, 22, 23, 8, 9, 10, 11, 20, 21, 22, 23});
  z = pick(z01, c, uint8x16_t{0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 28, 29, 30, 31});
}
}} // namespace cvert::CVERT_ISA
