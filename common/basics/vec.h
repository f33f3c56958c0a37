// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Plain numbers without alignment or SIMD. */

#include <algorithm>
#include <cmath>
#include <limits>

namespace programs {

struct Vec2f {
  float x = 0, y = 0;
};

inline Vec2f operator+(Vec2f a, Vec2f b) { return {a.x + b.x, a.y + b.y}; }
inline Vec2f operator-(Vec2f a, Vec2f b) { return {a.x - b.x, a.y - b.y}; }
inline Vec2f operator*(Vec2f a, float s) { return {a.x * s, a.y * s}; }

template<typename T>
struct Vec3 {
  T x = 0, y = 0, z = 0;

  friend Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3 operator*(Vec3 a, T s) { return {a.x * s, a.y * s, a.z * s}; }
  friend Vec3 operator*(T s, Vec3 a) { return a * s; }
  friend Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend Vec3& operator+=(Vec3& a, Vec3 b) { return a = a + b; }
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

inline Vec3d toDouble(Vec3f a) { return {a.x, a.y, a.z}; }

template<typename T>
T dot(Vec3<T> a, Vec3<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* True if the square of a vector's length did not over- or underflow, so that its root is accurate. */
template<typename T>
bool isAccurateSquare(T square) {
  using Limits = std::numeric_limits<T>;
  return square >= Limits::min() / Limits::epsilon() && square <= Limits::max();
}

/* Scales a vector so that its largest component is 1. Returns its previous magnitude; does nothing and returns 0 for
 * vectors that are zero or not finite. */
template<typename T>
T scaleToOne(Vec3<T>& a) {
  const T largest = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  if (!(largest > T(0) && largest <= std::numeric_limits<T>::max())) return T(0);
  a = {a.x / largest, a.y / largest, a.z / largest};
  return largest;
}

template<typename T>
T length(Vec3<T> a) {
  const T square = dot(a, a);
  if (isAccurateSquare(square)) return std::sqrt(square);
  const T scale = scaleToOne(a);
  return scale > T(0) ? scale * std::sqrt(dot(a, a)) : std::sqrt(square);
}

template<typename T>
Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* The zero vector stays zero. */
template<typename T>
Vec3<T> normalize(Vec3<T> a) {
  if (!isAccurateSquare(dot(a, a)) && scaleToOne(a) == T(0)) return a;
  return a * (T(1) / length(a));
}

/* True if normalize(a) has length 1, also if the square of a's length is out of range. */
template<typename T>
bool hasDirection(Vec3<T> a) {
  return length(normalize(a)) > T(0);
}

inline Vec3f lerp(Vec3f a, Vec3f b, float t) { return a + t * (b - a); }
inline Vec3f minimum(Vec3f a, Vec3f b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
inline Vec3f maximum(Vec3f a, Vec3f b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }
inline bool isFinite(Vec3f a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

struct Box3f {
  Vec3f lower{INFINITY, INFINITY, INFINITY};
  Vec3f upper{-INFINITY, -INFINITY, -INFINITY};

  void extend(Vec3f p) {
    lower = minimum(lower, p);
    upper = maximum(upper, p);
  }
  Vec3f center() const { return 0.5f * (lower + upper); }
  float diagonal() const { return length(upper - lower); }
};

} // namespace programs
