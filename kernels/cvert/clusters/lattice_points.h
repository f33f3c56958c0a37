// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices as integers on the coarsest lattice that contains them, for COMPRESSED1 and DGF. Nothing is rounded. These
 * formats store signed integers of 24 bits plus offsets of up to 16 bits, and spacings from 2^-126 to 2^105. */

#include "bits.h"
#include <cstring>

namespace cvert {
class LatticePoints {
public:
  static const uint32_t maxSide = 17;            //!< vertices per side
  static const int32_t lowestAnchor = -0x800000; //!< the highest is 0x7FFFFF
  static const int32_t maxOffset = 0xFFFF;

  int32_t at[maxSide * maxSide][3];  //!< row by row; 0 for vertices that are not finite
  bool isPresent[maxSide * maxSide]; //!< the vertex is finite
  uint32_t width;
  uint32_t exponent; //!< biased, of the spacing, 1 to 232

  /*! Converts columns x rows vertices, at most maxSide each. stride: vertices per row of the input. Returns false if
   *  the formats would round them. */
  bool set(const float* vertices, uint32_t stride, uint32_t columns, uint32_t rows) {
    width = columns;
    int lowest = maxExponent;
    for (uint32_t y = 0; y < rows; y++)
      for (uint32_t x = 0; x < columns; x++) {
        const float* p = vertices + 3 * (size_t(y) * stride + x);
        const Parts parts[3] = {Parts(p[0]), Parts(p[1]), Parts(p[2])};
        const uint32_t i = y * width + x;
        isPresent[i] = parts[0].isFinite() && parts[1].isFinite() && parts[2].isFinite();
        if (!isPresent[i]) continue;
        for (int k = 0; k < 3; k++)
          if (parts[k].mantissa != 0) lowest = lowest < parts[k].lowestBit() ? lowest : parts[k].lowestBit();
      }
    if (lowest < minExponent) return false;
    exponent = uint32_t(lowest + 127);
    for (uint32_t y = 0; y < rows; y++)
      for (uint32_t x = 0; x < columns; x++)
        for (int k = 0; k < 3; k++)
          if (!convert(vertices[3 * (size_t(y) * stride + x) + k], lowest, isPresent[y * width + x],
                       at[y * width + x][k]))
            return false;
    return true;
  }

private:
  static const int minExponent = -126, maxExponent = 105;

  /*! |x| = mantissa * 2^exponent, if x is finite. */
  struct Parts {
    bool isNegative;
    uint32_t mantissa;
    int exponent;

    explicit Parts(float x) {
      uint32_t bits;
      memcpy(&bits, &x, sizeof(bits));
      const uint32_t stored = (bits >> 23) & 255u;
      isNegative = (bits >> 31) != 0;
      mantissa = (bits & 0x7FFFFFu) | (stored != 0 ? 0x800000u : 0u);
      exponent = int(stored != 0 ? stored : 1u) - 150;
    }

    bool isFinite() const { return exponent != 255 - 150; }
    int lowestBit() const { return exponent + __builtin_ctz(mantissa); }
  };

  static bool convert(float x, int spacing, bool isPresent, int32_t& out) {
    out = 0;
    const Parts parts(x);
    if (!isPresent || parts.mantissa == 0) return true;
    const int shift = parts.exponent - spacing;
    if (shift > 8) return false;
    // exact: the spacing is at most the lowest bit
    const int64_t size = shift >= 0 ? int64_t(parts.mantissa) << shift : int64_t(parts.mantissa >> -shift);
    const int64_t value = parts.isNegative ? -size : size;
    if (value < lowestAnchor || value >= -int64_t(lowestAnchor) + maxOffset) return false;
    out = int32_t(value);
    return true;
  }
};

/*! Bounds of points, initially empty. */
struct LatticeSpan {
  int32_t lower[3], upper[3];

  LatticeSpan() {
    for (int k = 0; k < 3; k++) {
      lower[k] = 0x7FFFFFFF;
      upper[k] = -0x7FFFFFFF;
    }
  }

  void add(const int32_t* p) { add(p, p); }
  void add(const LatticeSpan& other) { add(other.lower, other.upper); }
  void add(const int32_t* least, const int32_t* most) {
    for (int k = 0; k < 3; k++) {
      lower[k] = lower[k] < least[k] ? lower[k] : least[k];
      upper[k] = upper[k] > most[k] ? upper[k] : most[k];
    }
  }

  bool isEmpty() const { return lower[0] > upper[0]; }

  /*! True if an anchor and offsets can represent all points. */
  bool fits() const {
    for (int k = 0; k < 3; k++)
      if (lower[k] >= -LatticePoints::lowestAnchor || upper[k] - lower[k] > LatticePoints::maxOffset) return false;
    return true;
  }

  /*! Bits of offsets on axis k, 1 to 16 if fits(). */
  uint32_t bits(int k) const { return upper[k] > lower[k] ? bitWidth(uint32_t(upper[k] - lower[k])) : 1; }
};
} // namespace cvert
