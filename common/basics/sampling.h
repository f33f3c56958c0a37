// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Random numbers that are the same on every machine, unlike the distributions of the standard library. Directions are
 * the same up to the rounding of sin and cos. */

#include "basics/vec.h"

#include <cstdint>
#include <random>

namespace programs {

/* Uniform in [0,1). */
inline float uniform(std::mt19937& random) { return float(random() >> 8) * 0x1p-24f; }

/* Uniform in [0,n), 0 < n <= 2^32. */
inline size_t uniformIndex(size_t n, std::mt19937& random) { return size_t((uint64_t(random()) * n) >> 32); }

/* Unit direction with this cosine, in [-1,1], to the unit vector n, rotated by `angle` radians about n. */
inline Vec3f directionAround(Vec3f n, float cosine, float angle) {
  const Vec3f s = normalize(std::abs(n.x) > 0.5f ? cross(n, Vec3f{0, 1, 0}) : cross(n, Vec3f{1, 0, 0}));
  const Vec3f t = cross(n, s);
  const float sine = std::sqrt(1.0f - cosine * cosine);
  return normalize((sine * std::cos(angle)) * s + (sine * std::sin(angle)) * t + cosine * n);
}

/* Cosine-distributed about the unit vector n. */
inline Vec3f cosineDirection(Vec3f n, std::mt19937& random) {
  const float radius2 = uniform(random), angle = 2.0f * float(M_PI) * uniform(random);
  return directionAround(n, std::sqrt(1.0f - radius2), angle);
}

/* Uniform over the unit sphere. */
inline Vec3f uniformDirection(std::mt19937& random) {
  const float z = 2.0f * uniform(random) - 1.0f, angle = 2.0f * float(M_PI) * uniform(random);
  return directionAround({0, 0, 1}, z, angle);
}

} // namespace programs
