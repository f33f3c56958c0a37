// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a cVERT block at a time step, converted to coordinates and remainders of format/block.h. Encoders call
 * setSize(), computeBounds(), chooseSpacings() and computeCoordinates(), in this order.
 *
 * Nothing is rounded. The step of an axis is the largest power of two that divides all vertices. If the block's
 * spacing, also a power of two, is larger than the step, vertices have remainders. */

#include "../format/block.h"
#include "cell_encoder.h"
#include "../portable/vertices4.h"
#include <algorithm>

namespace cvert { inline namespace CVERT_ISA {
/*! Reciprocals of these spacings are normal floats. */
static const int minSpacingExponent = -126, maxSpacingExponent = 126;

class BlockVertices {
public:
  static const uint32_t maxSide = (1u << maxVertLevel) + 1u;
  static const uint32_t maxVertices = maxSide * maxSide + 3; //!< padded to vectors of four

  float vertices[maxVertices][3]; //!< row by row
  float lower[3], upper[3];       //!< bounds of the finite vertices; lower is infinity if there are none
  bool allFinite;

  uint32_t quads[2], width;  //!< quads along u and v; vertices per row
  int exponent[3];           //!< exponents of the spacings
  uint32_t remainderBits[3]; //!< 0 to maxRemainderBits, or remaindersAreFloats
  float origin[3];
  int coordinates[3][maxVertices]; //!< by axis, padded with the first vertex
  uint32_t remainders[3][maxVertices];

  void setSize(uint32_t region) {
    quads[0] = vertQuadsX(region);
    quads[1] = vertQuadsY(region);
    width = quads[0] + 1;
  }

  uint32_t numVertices() const { return width * (quads[1] + 1); }
  const float* vertexAt(uint32_t x, uint32_t y) const { return vertices[y * width + x]; }
  bool anyFinite() const { return lower[0] <= upper[0]; }

  /*! Sets bounds and allFinite. */
  void computeBounds() {
    allFinite = boundsOfVertices(vertices, numVertices(), lower, upper);
    if (allFinite) return;
    for (int k = 0; k < 3; k++) {
      lower[k] = INFINITY;
      upper[k] = -INFINITY;
    }
    for (uint32_t i = 0; i < numVertices(); i++) {
      if (!isFinite(vertices[i])) continue;
      for (int k = 0; k < 3; k++) {
        lower[k] = std::min(lower[k], vertices[i][k]);
        upper[k] = std::max(upper[k], vertices[i][k]);
      }
    }
  }

  uint32_t countInvalidQuads() const {
    uint32_t n = 0;
    for (uint32_t y = 0; y < quads[1]; y++)
      for (uint32_t x = 0; x < quads[0]; x++)
        n += !(isFinite(vertexAt(x, y)) && isFinite(vertexAt(x + 1, y)) && isFinite(vertexAt(x, y + 1)) &&
               isFinite(vertexAt(x + 1, y + 1)));
    return n;
  }

  bool hasRemainders() const { return (remainderBits[0] | remainderBits[1] | remainderBits[2]) != 0; }

  /*! Sets spacings to the steps, or to the least spacings that coordinates of some bits allow if these are larger.
   *  Requires finite vertices. Returns false if the block must be raw. */
  bool chooseSpacings(int bits = extentBits) {
    for (uint32_t i = numVertices(); i % 4 != 0; i++) memcpy(vertices[i], vertices[0], sizeof(vertices[0]));
    int size = minSpacingExponent; // 2^size exceeds all extents
    for (int k = 0; k < 3; k++) {
      const double span = double(upper[k]) - double(lower[k]);
      if (span > 0) size = std::max(size, std::ilogb(span) + 1);
    }
    findSteps();
    // min, because the step is large without reason on an axis where all vertices are 0
    for (int k = 0; k < 3; k++) exponent[k] = std::max(leastExponent(k, bits), std::min(step[k], size - 1));
    return setRemainders();
  }

  /*! Multiplies spacings by 2^bits: residuals become shorter, remainders longer. False if a spacing is too large. */
  bool coarsen(const int bits[3]) {
    for (int k = 0; k < 3; k++) exponent[k] += bits[k];
    return setRemainders();
  }

  /*! Computes origin, coordinates and remainders for the current spacings. */
  void computeCoordinates() {
    for (int k = 0; k < 3; k++) {
      const double unit = std::ldexp(1.0, -exponent[k]);
      origin[k] = float(std::floor(lower[k] * unit) / unit);
    }
    const Float4 units[3] = {std::ldexp(1.0f, -exponent[0]), std::ldexp(1.0f, -exponent[1]),
                             std::ldexp(1.0f, -exponent[2])};
    for (uint32_t i = 0; i < numVertices(); i += 4) {
      const Vertices4 p(vertices + i);
      truncateToInt((p.x - Float4(origin[0])) * units[0]).store(coordinates[0] + i);
      truncateToInt((p.y - Float4(origin[1])) * units[1]).store(coordinates[1] + i);
      truncateToInt((p.z - Float4(origin[2])) * units[2]).store(coordinates[2] + i);
    }
    for (int k = 0; k < 3; k++)
      if (remainderBits[k] != 0) computeWithRemainders(k);
  }

  /*! Copies an axis of a cell's 5 x 5 vertices, padded with the last one. step: quads between them. Repeats the
   *  block's last column and row in cells that extend beyond it. */
  void gather(const int* values, uint32_t x0, uint32_t y0, uint32_t step, int out[paddedVertices]) const {
    for (uint32_t j = 0; j < 5; j++) {
      const int* row = values + std::min(y0 + step * j, quads[1]) * width;
      if (step == 1 && x0 + 4 <= quads[0]) {
        memcpy(out + 5 * j, row + x0, 5 * sizeof(*row));
        continue;
      }
      for (uint32_t i = 0; i < 5; i++) out[5 * j + i] = row[std::min(x0 + step * i, quads[0])];
    }
    for (int v = cellVertices; v < paddedVertices; v++) out[v] = out[cellVertices - 1];
  }

  /*! Writes NaN for vertices that are not finite: rays might hit triangles with infinity, but never with NaN. */
  void copyTo(float (*out)[3]) const {
    for (uint32_t i = 0; i < numVertices(); i++)
      for (int k = 0; k < 3; k++) out[i][k] = isFinite(vertices[i]) ? vertices[i][k] : NAN;
  }

  static void writeVersion(uint32_t corners[6]) {
    for (uint32_t i = 0; i < 4; i++) corners[4 + (i >> 1)] |= ((vertFormatVersion >> i) & 1u) << (15 + 16 * (i & 1));
  }

  /*! Writes origin, spacings and corners into a header, whose bits for spacings and corners must be 0. */
  void write(float origin[3], uint32_t corners[6], uint32_t& word) const {
    memcpy(origin, this->origin, sizeof(this->origin));
    word |= uint32_t(exponent[0] + 127) << 24;
    const uint32_t y = uint32_t(exponent[1] + 127), z = uint32_t(exponent[2] + 127);
    for (uint32_t i = 0; i < 8; i++)
      corners[i >> 1] |= (((y >> i) & 1u) << 15 | ((z >> i) & 1u) << 14) << (16 * (i & 1));
    for (uint32_t c = 0; c < 4; c++)
      for (int k = 0; k < 3; k++)
        corners[cornerPair(int(c), k)] |= uint32_t(coordinates[k][(c >> 1) * quads[1] * width + (c & 1) * quads[0]])
                                          << (16 * ((3 * c + uint32_t(k)) & 1));
  }

  /*! Writes the remainders, and returns their end. offset: byte offset of `out` in the block or step. word: receives
   *  the word of remainders. */
  uint8_t* writeRemainders(uint8_t* out, uint32_t offset, uint32_t& word) const {
    word = remainderBits[0] | remainderBits[1] << 5 | remainderBits[2] << 10 | offset << 16;
    BitWriter writer(out);
    for (uint32_t i = 0; i < numVertices(); i++)
      for (int k = 0; k < 3; k++)
        if (remainderBits[k] != 0) writer.write(remainders[k][i], storedRemainderBits(word, k));
    return writer.finish();
  }

private:
  static const int extentBits = 14;
  static_assert(maxExtent == 1 << extentBits, "coordinates of blocks");

  /*! On an axis stored as floats, coordinates serve only boxes. They are at most 2^(unitsOfFloats+1), so that they
   *  need few bits. */
  static const int unitsOfFloats = 6;

  /*! Highest bit of integers in findSteps. Differences fit into an int. */
  static const int integerBits = 29;

  int step[3]; //!< exponents of the steps

  /*! Exponent of the largest power of two that is at most |x|; -127 if x is 0 or denormal. */
  static int exponentOf(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof(bits));
    return int((bits >> 23) & 255u) - 127;
  }

  /*! Scales each axis to integers. If this is exact, the step is the lowest bit in which any two of them differ. */
  void findSteps() {
    Float4 scale[3], unit[3];
    Int4 first[3], any[3] = {0, 0, 0};
    int exponents[3];
    for (int k = 0; k < 3; k++) {
      exponents[k] =
          std::max(exponentOf(std::max(std::fabs(lower[k]), std::fabs(upper[k]))) - integerBits, minSpacingExponent);
      scale[k] = std::ldexp(1.0f, -exponents[k]);
      unit[k] = std::ldexp(1.0f, exponents[k]);
      first[k] = truncateToInt(Float4(vertices[0][k]) * scale[k]);
    }
    uint32_t integral[3] = {15, 15, 15};
    for (uint32_t i = 0; i < numVertices(); i += 4) {
      const Vertices4 p(vertices + i);
      auto add = [&](int k, Float4 x) {
        const Int4 n = truncateToInt(x * scale[k]); // 0 if the product underflows
        integral[k] &= equalBits(toFloat(n) * unit[k], x);
        any[k] = any[k] | (n - first[k]);
      };
      add(0, p.x);
      add(1, p.y);
      add(2, p.z);
    }
    for (int k = 0; k < 3; k++) {
      const unsigned differences = integral[k] == 15 ? unsigned(reduceOr(any[k])) : 0;
      if (differences != 0) {
        // the vertices themselves must be multiples of the step, not only their differences
        const float vertex = vertices[0][k];
        step[k] =
            std::min(exponents[k] + __builtin_ctz(differences), vertex != 0 ? lowestBit(vertex) : maxSpacingExponent);
      } else findStepOfFloats(k);
    }
  }

  /*! Exponent of the lowest set bit of x, which must not be 0. Less than minSpacingExponent for denormals, which
   *  readers may treat as 0. */
  static int lowestBit(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof(bits));
    const uint32_t stored = (bits >> 23) & 255u;
    return stored == 0 ? minSpacingExponent - 1 : int(stored) - 150 + __builtin_ctz((bits & 0x7FFFFFu) | 0x800000u);
  }

  /*! Finds the step from the bits of the floats. */
  void findStepOfFloats(int k) {
    step[k] = maxSpacingExponent;
    const uint32_t count = lower[k] == upper[k] ? 1 : numVertices();
    for (uint32_t i = 0; i < count; i++)
      if (vertices[i][k] != 0) step[k] = std::min(step[k], lowestBit(vertices[i][k]));
    // too fine for remainders: makes setRemainders select floats
    if (step[k] < minSpacingExponent) step[k] = minSpacingExponent - 2 * int(maxRemainderBits);
  }

  /*! Exponent of the smallest spacing with coordinates below 2^bits, and with planes of boxes that are exact in float,
   *  up to 2^bits spacings outside the vertices. */
  int leastExponent(int k, int bits) const {
    const int extent = 1 << bits;
    const double largest = std::max(std::fabs(double(lower[k])), std::fabs(double(upper[k])));
    const double span = double(upper[k]) - double(lower[k]);
    int e = minSpacingExponent;
    if (largest > 0) e = std::max(e, std::ilogb(largest) - 23);
    if (span > 0) e = std::max(e, std::ilogb(span) - (bits - 1));
    for (;; e++) {
      const double unit = std::ldexp(1.0, -e);
      if (largest * unit <= double((1 << 24) - 2 * extent) && upper[k] * unit - std::floor(lower[k] * unit) < extent)
        return e;
    }
  }

  /*! Chooses the bits of remainders for the current spacings, and enlarges the spacing of an axis that needs floats.
   *  Returns false if a spacing is too large. */
  bool setRemainders() {
    for (int k = 0; k < 3; k++) {
      if (exponent[k] > maxSpacingExponent) return false;
      const int bits = std::max(exponent[k] - step[k], 0);
      remainderBits[k] = bits > int(maxRemainderBits) ? remaindersAreFloats : uint32_t(bits);
      const double span = double(upper[k]) - double(lower[k]);
      if (remainderBits[k] == remaindersAreFloats && span > 0)
        exponent[k] = std::max(exponent[k], std::ilogb(span) - unitsOfFloats);
    }
    return true;
  }

  void computeWithRemainders(int k) {
    const double unit = std::ldexp(1.0, -exponent[k]), first = double(origin[k]) * unit,
                 remainderUnits = std::ldexp(1.0, int(remainderBits[k]));
    for (uint32_t i = 0; i < ((numVertices() + 3u) & ~3u); i++) {
      const double at = double(vertices[i][k]) * unit, whole = std::floor(at);
      coordinates[k][i] = int(whole - first);
      if (remainderBits[k] == remaindersAreFloats) memcpy(&remainders[k][i], &vertices[i][k], sizeof(float));
      else remainders[k][i] = uint32_t((at - whole) * remainderUnits);
    }
  }
};
}} // namespace cvert::CVERT_ISA
