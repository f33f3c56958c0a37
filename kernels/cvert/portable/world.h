// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vectors and bounds in world space, in double precision. */

#include "language.h"
#include <cmath>

namespace cvert { inline namespace CVERT_ISA {
/*! Coordinates of at least this magnitude count as not finite, as in Embree (FLT_LARGE), so areas cannot overflow. */
static constexpr float maxCoordinate = 1.844e18f;
inline bool isFinite(const float p[3]) {
  return std::fabs(p[0]) < maxCoordinate && std::fabs(p[1]) < maxCoordinate && std::fabs(p[2]) < maxCoordinate;
}

struct Double3 {
  double x, y, z;
  friend Double3 operator+(const Double3& a, const Double3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Double3 operator-(const Double3& a, const Double3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Double3 operator*(double s, const Double3& a) { return {s * a.x, s * a.y, s * a.z}; }
};
inline double dot(const Double3& a, const Double3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Double3 cross(const Double3& a, const Double3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Double3& a) { return std::sqrt(dot(a, a)); }
inline double norm1(const Double3& a) { return std::fabs(a.x) + std::fabs(a.y) + std::fabs(a.z); }

/*! An axis-aligned box, initially empty. */
struct WorldBounds {
  double lower[3] = {1e300, 1e300, 1e300}, upper[3] = {-1e300, -1e300, -1e300};

  void extend(const WorldBounds& other) {
    for (int k = 0; k < 3; k++) {
      lower[k] = minimum(lower[k], other.lower[k]);
      upper[k] = maximum(upper[k], other.upper[k]);
    }
  }
  void extend(double x, double y, double z) {
    const double p[3] = {x, y, z};
    for (int k = 0; k < 3; k++) {
      lower[k] = minimum(lower[k], p[k]);
      upper[k] = maximum(upper[k], p[k]);
    }
  }
  bool isEmpty() const { return lower[0] > upper[0]; }
  bool contains(const WorldBounds& other) const {
    bool inside = true;
    for (int k = 0; k < 3; k++) inside &= lower[k] <= other.lower[k] && other.upper[k] <= upper[k];
    return inside;
  }
};
}} // namespace cvert::CVERT_ISA
