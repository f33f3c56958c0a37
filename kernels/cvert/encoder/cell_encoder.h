// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes a cell (format/cell.h). */

#include "../format/cell.h"
#include "../portable/bits.h"
#include "../portable/lanes.h"
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace cvert { inline namespace CVERT_ISA {
/*! cellVertices, padded to whole vectors. */
static const int paddedVertices = 28;

/*! Set `vertices`, then call predict(), encode() or encodeWithoutSlopes(), and write(). */
class CellEncoder {
public:
  /*! Coordinates by axis, row by row, from 0 to maxExtent-1, padded with the last vertex. */
  int vertices[3][paddedVertices];

  int residuals[3][paddedVertices]; //!< by axis; set by predict(), modified by encode()

  /*! Sets the residuals. quads: of the cell, along u and v. step: quads from vertex to vertex. */
  void predict(const uint32_t quads[2], uint32_t step) {
    setWeights(quads, step);
    for (int k = 0; k < 3; k++) {
      const int* c = vertices[k];
      const int c00 = c[0], c10 = c[4], c01 = c[20], c11 = c[24];
      const Int4 alongX = 16 * (c10 - c00), alongY = 16 * (c01 - c00), twist = c11 - c10 - c01 + c00;
      for (int v = 0; v < paddedVertices; v += 4) // as cellPrediction
      {
        const Int4 x = Int4::load(weightX + v), y = Int4::load(weightY + v);
        const Int4 sum = x * alongX + y * alongY + x * y * twist;
        (Int4::load(c + v) - (Int4(c00) + shiftArithmetic(sum + Int4(128), 8))).store(residuals[k] + v);
      }
    }
  }

  /*! Sets `word`. If residuals have too many bits, sets `excess` and returns false. */
  bool encode() {
    float squares[3], others[3];
    sumProducts(residuals[0], residuals[0], residuals[1], residuals[1], residuals[2], residuals[2], squares);
    const int main = squares[0] >= squares[1] && squares[0] >= squares[2] ? 0 : squares[1] >= squares[2] ? 1 : 2;
    int* const r[3] = {residuals[main], residuals[axisAfter(main, 1)], residuals[axisAfter(main, 2)]};
    sumProducts(r[0], r[0], r[0], r[1], r[0], r[2], others);
    int bits[3] = {bitsOf(r[0]), 0, 0};
    int slopes[3] = {0, 0, 0};
    for (int i = 1; i < 3; i++) slopes[i] = removeSlope(r[0], squares[main], others[i], r[i], bits[i]);
    if (!fits(bits, main)) return false;
    word = uint32_t(bits[0]) | uint32_t(bits[1]) << 4 | uint32_t(bits[2]) << 8 | uint32_t(main) << 12 |
           (uint32_t(slopes[1]) & 31u) << 14 | (uint32_t(slopes[2]) & 31u) << 19;
    return true;
  }

  /*! encode() without main axis and slopes, for differences from rotated residuals. */
  bool encodeWithoutSlopes() {
    const int bits[3] = {bitsOf(residuals[0]), bitsOf(residuals[1]), bitsOf(residuals[2])};
    if (!fits(bits, 0)) return false;
    word = uint32_t(bits[0]) | uint32_t(bits[1]) << 4 | uint32_t(bits[2]) << 8;
    return true;
  }

  uint32_t word; //!< see format/cell.h
  int excess[3]; //!< by axis: bits above maxResidualBits if encode fails

  /*! Writes the fields, after encode() or encodeWithoutSlopes(). Returns their end. */
  uint8_t* write(uint8_t* out) const {
    const int main = cellMainAxis(word), sum = cellFieldBits(word);
    const int bits[3] = {cellBits(word, 0), cellBits(word, 1), cellBits(word, 2)};
    const int* component[3] = {residuals[main], residuals[cellAxis(word, 1)], residuals[cellAxis(word, 2)]};
    BitWriter writer(out);
    alignas(16) uint32_t fields[paddedVertices];
    auto residual = [&](int i, int v) { return Int4::load(component[i] + v) & Int4(int((1u << bits[i]) - 1u)); };
    auto put = [&](int width) {
      for (int v = 0; v < cellVertices; v++)
        if (!isCorner(v)) writer.write(fields[v], width);
    };
    if (isByAxis(word)) {
      for (int i = 0; i < 3; i++) {
        for (int v = 0; v < paddedVertices; v += 4) residual(i, v).store(fields + v);
        put(bits[i]);
      }
    } else {
      for (int v = 0; v < paddedVertices; v += 4)
        (residual(0, v) | (residual(1, v) << bits[0]) | (residual(2, v) << (bits[0] + bits[1]))).store(fields + v);
      put(sum);
    }
    return writer.finish();
  }

private:
  /*! Sets `excess`. bits: of residuals on the main axis and the next two axes. */
  bool fits(const int bits[3], int main) {
    for (int i = 0; i < 3; i++) excess[axisAfter(main, i)] = std::max(bits[i] - maxResidualBits, 0);
    return (excess[0] | excess[1] | excess[2]) == 0;
  }

  static bool isCorner(int v) { return v == 0 || v == 4 || v == 20 || v == 24; }

  /*! Reuses the weights of the previous call if they are the same, as for most cells of a block. */
  void setWeights(const uint32_t quads[2], uint32_t step) {
    const uint32_t key[3] = {quads[0], quads[1], step};
    if (memcmp(key, weightsOf, sizeof(key)) == 0) return;
    memcpy(weightsOf, key, sizeof(key));
    for (int i = 0; i < 5; i++) {
      const int x = weight(i, int(step), int(quads[0])), y = weight(i, int(step), int(quads[1]));
      for (int j = 0; j < 5; j++) {
        weightX[5 * j + i] = x;
        weightY[5 * i + j] = y;
      }
    }
    for (int v = cellVertices; v < paddedVertices; v++) {
      weightX[v] = weightX[cellVertices - 1];
      weightY[v] = weightY[cellVertices - 1];
    }
  }

  /*! cellWeight, but divides only for inner vertices. */
  static int weight(int i, int step, int quads) {
    return step * i >= quads ? 16 : i == 0 ? 0 : cellWeight(i, step, quads);
  }

  /*! sums: receives the sums of a*b, c*d and e*f over the vertices, added in the order of the vertices, so that all
   *  instruction sets encode the same. */
  static void sumProducts(const int* a, const int* b, const int* c, const int* d, const int* e, const int* f,
                          float sums[3]) {
    float products[3][paddedVertices];
    auto multiply = [](const int* x, const int* y, float* out) {
      for (int v = 0; v < paddedVertices; v += 4)
        (toFloat(Int4::load(x + v)) * toFloat(Int4::load(y + v))).store(out + v);
    };
    multiply(a, b, products[0]);
    multiply(c, d, products[1]);
    multiply(e, f, products[2]);
    float sum0 = 0, sum1 = 0, sum2 = 0; // interleaved to hide latency
    for (int v = 0; v < cellVertices; v++) {
      sum0 += products[0][v];
      sum1 += products[1][v];
      sum2 += products[2][v];
    }
    sums[0] = sum0;
    sums[1] = sum1;
    sums[2] = sum2;
  }

  /*! Bits of the residuals in two's complement. Residuals of corners must be 0. */
  static int bitsOf(const int r[paddedVertices]) {
    Int4 used = 0, any = 0;
    for (int v = 0; v < paddedVertices; v += 4) {
      const Int4 x = Int4::load(r + v);
      used = used | (x ^ shiftArithmetic(x, 31));
      any = any | x;
    }
    const int bits = reduceOr(used);
    return bits ? 33 - __builtin_clz(unsigned(bits)) : reduceOr(any) ? 1 : 0;
  }

  /*! Subtracts from component r what the best slope predicts, if this saves bits. Returns the slope or 0. main:
   *  component on the main axis. squares, products: sums of main*main and main*r. bits: receives the bits of r. */
  static int removeSlope(const int main[paddedVertices], float squares, float products, int r[paddedVertices],
                         int& bits) {
    bits = bitsOf(r);
    if (!(squares > 0) || bits == 0) return 0;
    const float fit = 16 * products / squares;
    const int slope = fit < -maxSlope ? -maxSlope : fit > maxSlope ? maxSlope : int(std::floor(fit + 0.5f));
    if (slope == 0) return 0;
    int rest[paddedVertices];
    for (int v = 0; v < paddedVertices; v += 4) // as slopeResidual
      (Int4::load(r + v) - shiftArithmetic(Int4(slope) * Int4::load(main + v) + Int4(8), 4)).store(rest + v);
    const int restBits = bitsOf(rest);
    if (restBits >= bits) return 0;
    memcpy(r, rest, sizeof(rest));
    bits = restBits;
    return slope;
  }

  int weightX[paddedVertices], weightY[paddedVertices]; //!< weights of upper corners, in 1/16
  uint32_t weightsOf[3] = {0, 0, 0};                    //!< their quads and step
};
}} // namespace cvert::CVERT_ISA
