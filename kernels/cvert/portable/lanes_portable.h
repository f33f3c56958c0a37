// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The functions of lanes_sse.h in plain C++, with the same results: for other processors, and for tests. */

#include "language.h"
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace cvert { inline namespace CVERT_ISA {
struct Float4 {
  float v[4];

  Float4() {}
  Float4(float a) : v{a, a, a, a} {}
  Float4(float a, float b, float c, float d) : v{a, b, c, d} {}
  static Float4 load(const float* p) { return Float4(p[0], p[1], p[2], p[3]); }
  void store(float* p) const { std::memcpy(p, v, sizeof(v)); }

  template<typename Operation>
  static Float4 map(const Operation& lane) {
    return Float4(lane(0), lane(1), lane(2), lane(3));
  }

  friend Float4 operator+(Float4 a, Float4 b) {
    return map([&](int i) { return a.v[i] + b.v[i]; });
  }
  friend Float4 operator-(Float4 a, Float4 b) {
    return map([&](int i) { return a.v[i] - b.v[i]; });
  }
  friend Float4 operator*(Float4 a, Float4 b) {
    return map([&](int i) { return a.v[i] * b.v[i]; });
  }
};

struct FloatMask4 {
  bool v[4];
};

inline Float4 min(Float4 a, Float4 b) {
  return Float4::map([&](int i) { return b.v[i] < a.v[i] ? b.v[i] : a.v[i]; });
}
inline Float4 max(Float4 a, Float4 b) {
  return Float4::map([&](int i) { return b.v[i] > a.v[i] ? b.v[i] : a.v[i]; });
}
inline Float4 abs(Float4 a) {
  return Float4::map([&](int i) { return std::fabs(a.v[i]); });
}

inline FloatMask4 lessThan(Float4 a, Float4 b) {
  return FloatMask4{{a.v[0] < b.v[0], a.v[1] < b.v[1], a.v[2] < b.v[2], a.v[3] < b.v[3]}};
}
inline Float4 operator&(FloatMask4 mask, Float4 a) {
  return Float4::map([&](int i) { return mask.v[i] ? a.v[i] : 0.0f; });
}
inline Float4 select(FloatMask4 mask, Float4 a, Float4 b) {
  return Float4::map([&](int i) { return mask.v[i] ? a.v[i] : b.v[i]; });
}

inline float reduceMax(Float4 a) {
  const Float4 m = max(Float4(a.v[2], a.v[3], a.v[2], a.v[3]), a);
  return m.v[0] > m.v[1] ? m.v[0] : m.v[1];
}

template<typename Comparison>
inline uint32_t laneBits(const Comparison& compare) {
  return uint32_t(compare(0)) | uint32_t(compare(1)) << 1 | uint32_t(compare(2)) << 2 | uint32_t(compare(3)) << 3;
}
inline uint32_t lessThanBits(Float4 a, Float4 b) {
  return laneBits([&](int i) { return a.v[i] < b.v[i]; });
}
inline uint32_t equalBits(Float4 a, Float4 b) {
  return laneBits([&](int i) { return a.v[i] == b.v[i]; });
}

struct Int4 {
  uint32_t v[4];

  Int4() {}
  Int4(int a) : v{uint32_t(a), uint32_t(a), uint32_t(a), uint32_t(a)} {}
  static Int4 load(const uint32_t* p) {
    Int4 a;
    std::memcpy(a.v, p, sizeof(a.v));
    return a;
  }
  static Int4 load(const int* p) {
    Int4 a;
    std::memcpy(a.v, p, sizeof(a.v));
    return a;
  }
  void store(uint32_t* p) const { std::memcpy(p, v, sizeof(v)); }
  void store(int* p) const { std::memcpy(p, v, sizeof(v)); }

  template<typename Operation>
  static Int4 map(const Operation& lane) {
    Int4 a;
    for (int i = 0; i < 4; i++) a.v[i] = uint32_t(lane(i));
    return a;
  }

  friend Int4 operator+(Int4 a, Int4 b) {
    return map([&](int i) { return a.v[i] + b.v[i]; });
  }
  friend Int4 operator-(Int4 a, Int4 b) {
    return map([&](int i) { return a.v[i] - b.v[i]; });
  }
  friend Int4 operator*(Int4 a, Int4 b) {
    return map([&](int i) { return a.v[i] * b.v[i]; });
  }
  friend Int4 operator|(Int4 a, Int4 b) {
    return map([&](int i) { return a.v[i] | b.v[i]; });
  }
  friend Int4 operator&(Int4 a, Int4 b) {
    return map([&](int i) { return a.v[i] & b.v[i]; });
  }
  friend Int4 operator^(Int4 a, Int4 b) {
    return map([&](int i) { return a.v[i] ^ b.v[i]; });
  }
  friend Int4 operator<<(Int4 a, int n) {
    return map([&](int i) { return n < 32 ? a.v[i] << n : 0u; });
  }
  friend Int4 operator>>(Int4 a, int n) {
    return map([&](int i) { return n < 32 ? a.v[i] >> n : 0u; });
  }
};

inline Int4 shiftArithmetic(Int4 a, int n) {
  return Int4::map([&](int i) { return int32_t(a.v[i]) >> (n < 32 ? n : 31); });
}

inline Int4 min(Int4 a, Int4 b) {
  return Int4::map([&](int i) { return int32_t(a.v[i]) < int32_t(b.v[i]) ? a.v[i] : b.v[i]; });
}
inline Int4 max(Int4 a, Int4 b) {
  return Int4::map([&](int i) { return int32_t(a.v[i]) > int32_t(b.v[i]) ? a.v[i] : b.v[i]; });
}

template<typename Operation>
inline int reduce(Int4 a, const Operation& operation) {
  Int4 result = int(a.v[0]);
  for (int i = 1; i < 4; i++) result = operation(result, Int4(int(a.v[i])));
  return int(result.v[0]);
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

inline Int4 square(Int4 a) { return a * a; }
inline Float4 toFloat(Int4 a) {
  return Float4::map([&](int i) { return float(int32_t(a.v[i])); });
}

inline Int4 truncateToInt(Float4 a) {
  return Int4::map([&](int i) { return std::fabs(a.v[i]) < 2147483648.0f ? int32_t(a.v[i]) : INT32_MIN; });
}

/* std::nearbyint rounds to nearest, halves to even, if the program keeps the default rounding mode. */
inline int roundToInt(float a) { return std::fabs(a) < 2147483648.0f ? int(std::nearbyint(a)) : INT32_MIN; }
inline Int4 roundToInt(Float4 a) {
  return Int4::map([&](int i) { return roundToInt(a.v[i]); });
}

inline void deinterleave(Float4 a, Float4 b, Float4 c, Float4& x, Float4& y, Float4& z) {
  x = Float4(a.v[0], a.v[3], b.v[2], c.v[1]);
  y = Float4(a.v[1], b.v[0], b.v[3], c.v[2]);
  z = Float4(a.v[2], b.v[1], c.v[0], c.v[3]);
}
}} // namespace cvert::CVERT_ISA
