// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Snaps four vertices at a time to a lattice, and detects quads that snapping flips. */

#include "../portable/vertices4.h"
#include "lattice.h"
#include <limits>

namespace cvert { inline namespace CVERT_ISA {
/*! Returns the largest squared distance, in squared spacings, by which a finite vertex moved. */
inline float snapFour(const WorldLattice& lattice, const float (*original)[3], float (*snapped)[3]) {
  Float4 square[3];
  for (int i = 0; i < 3; i++) {
    const Float4 p = Float4::load(&original[0][0] + 4 * i), q = lattice.snap(p), d = (p - q) * lattice.reciprocal;
    q.store(&snapped[0][0] + 4 * i);
    square[i] = d * d;
  }
  const Vertices4 s = Vertices4::deinterleaved(square[0], square[1], square[2]);
  const Float4 distance2 = s.x + s.y + s.z;
  return reduceMax(lessThan(distance2, std::numeric_limits<float>::max()) & distance2);
}

/*! Smallest magnitude of the dot product of two normals, in floats, from which underflow cannot change its sign. Its
 *  unit is the fourth power of a length. */
CVERT_CONSTANT float minNormalDot = 1e-30f;

/*! Computes, in double precision, if the normal of triangle (a,b,c) turned by more than 90 degrees. */
inline bool isTurned(const float (*original)[3], const float (*snapped)[3], size_t a, size_t b, size_t c) {
  const auto normal = [&](const float(*p)[3]) {
    const auto edge = [&](size_t i) {
      return Double3{double(p[i][0]) - p[a][0], double(p[i][1]) - p[a][1], double(p[i][2]) - p[a][2]};
    };
    return cross(edge(b), edge(c));
  };
  return dot(normal(original), normal(snapped)) < 0.0;
}

/*! Counts quads, of four in a row, with a triangle (00,10,01) or (10,11,01) whose normal turned by more than 90
 *  degrees. width: vertices per row. */
inline uint32_t countFlippedOfFour(const float (*original)[3], const float (*snapped)[3], size_t width) {
  struct Normals {
    Vertices4 lower, upper;

    Normals(const float (*p)[3], size_t width)
      : Normals(Vertices4(p), Vertices4(p + 1), Vertices4(p + width), Vertices4(p + width + 1)) {}
    Normals(const Vertices4& a, const Vertices4& b, const Vertices4& c, const Vertices4& d)
      : lower(cross(b - a, c - a)),
        upper(cross(d - b, c - b)) {}
  };
  const Normals n(original, width), m(snapped, width);
  const auto turnedBits = [&](Float4 normalDot, size_t a, size_t b, size_t c) {
    uint32_t turned = lessThanBits(normalDot, 0.0f);
    const Float4 size = abs(normalDot);
    const uint32_t isSignValid = lessThanBits(minNormalDot, size) & lessThanBits(size, infinity);
    for (uint32_t i = 0; isSignValid != 15 && i < 4; i++)
      if (!((isSignValid >> i) & 1))
        turned = (turned & ~(1u << i)) | uint32_t(isTurned(original + i, snapped + i, a, b, c)) << i;
    return turned;
  };
  const uint32_t flipped =
      turnedBits(dot(n.lower, m.lower), 0, 1, width) | turnedBits(dot(n.upper, m.upper), 1, width + 1, width);
  return uint32_t(uint64_t(0x4332322132212110u) >> (4 * flipped)) & 15u; // population count
}
}} // namespace cvert::CVERT_ISA
