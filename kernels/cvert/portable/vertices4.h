// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Four vertices at a time, and bounds of vertices. */

#include "lanes.h"
#include "world.h"

namespace cvert { inline namespace CVERT_ISA {
/*! Four consecutive vertices, one vector per axis. */
struct Vertices4 {
  Float4 x, y, z;

  Vertices4(Float4 x, Float4 y, Float4 z) : x(x), y(y), z(z) {}

  /*! Loads p[0] to p[3]. */
  explicit Vertices4(const float (*p)[3])
    : Vertices4(deinterleaved(Float4::load(&p[0][0]), Float4::load(&p[0][0] + 4), Float4::load(&p[0][0] + 8))) {}

  /*! See deinterleave. */
  static Vertices4 deinterleaved(Float4 a, Float4 b, Float4 c) {
    Float4 x, y, z;
    deinterleave(a, b, c, x, y, z);
    return Vertices4(x, y, z);
  }

  friend Vertices4 operator-(const Vertices4& a, const Vertices4& b) {
    return Vertices4(a.x - b.x, a.y - b.y, a.z - b.z);
  }
  friend Vertices4 cross(const Vertices4& a, const Vertices4& b) {
    return Vertices4(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  }
  friend Float4 dot(const Vertices4& a, const Vertices4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
};

/*! Computes bounds. Returns false if a vertex is not finite (isFinite); bounds are then undefined. */
inline bool boundsOfVertices(const float (*vertices)[3], size_t count, float lower[3], float upper[3]) {
  Float4 low = maxCoordinate, high = -maxCoordinate;
  uint32_t finiteAxes = 7;
  for (size_t i = 0; i < count; i++) {
    const Float4 v = loadVertex(vertices, i, count);
    finiteAxes &= lessThanBits(abs(v), maxCoordinate);
    low = min(low, v);
    high = max(high, v);
  }
  float bounds[2][4];
  low.store(bounds[0]);
  high.store(bounds[1]);
  for (int k = 0; k < 3; k++) {
    lower[k] = bounds[0][k];
    upper[k] = bounds[1][k];
  }
  return finiteAxes == 7;
}
}} // namespace cvert::CVERT_ISA
