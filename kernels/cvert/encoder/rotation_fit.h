// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Fits the 3x3 matrix that predicts the residuals of a block at a later time step from its residuals at the first, by
 * least squares (format/motion.h). Not only rotations: bending and growth are nearly linear over a block, too. */

#include "../format/motion.h"
#include "cell_encoder.h"

namespace cvert { inline namespace CVERT_ISA {
class RotationFit {
public:
  /*! residuals: of the first step's groups, by axis. Must remain valid for fit(). */
  void setFirst(const int (*residuals)[3][paddedVertices], uint32_t groups) {
    first = residuals;
    this->groups = groups;
    double s[3][3];
    sum(first, s);
    // regularizes axes without residuals
    for (int a = 0; a < 3; a++) s[a][a] += 0.001 * cellFields * groups;
    invert(s, inverse);
  }

  /*! Computes the matrix and rounds it to bytes. later: residuals of the same groups at another step. */
  void fit(const int (*later)[3][paddedVertices]) {
    double s[3][3], matrix[3][3], largest = 0;
    sum(later, s);
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        matrix[a][b] = s[a][0] * inverse[0][b] + s[a][1] * inverse[1][b] + s[a][2] * inverse[2][b];
        largest = std::max(largest, std::fabs(matrix[a][b]));
      }
    scale = 0;
    while (scale < 6 && largest * (1 << (7 - scale)) > 127.0) scale++;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        entries[a][b] = int(std::floor(std::min(std::max(matrix[a][b] * (1 << (7 - scale)), -127.0), 127.0) + 0.5));
  }

  /*! Sets `rest` to `to` minus the prediction from `from`. */
  void subtract(const int from[3][paddedVertices], const int to[3][paddedVertices], int rest[3][paddedVertices]) const {
    const int shift = int(7 - scale);
    for (int a = 0; a < 3; a++)
      for (int v = 0; v < paddedVertices; v += 4) { // as rotatedResidual
        const Int4 sum = Int4(entries[a][0]) * Int4::load(from[0] + v) + Int4(entries[a][1]) * Int4::load(from[1] + v) +
                         Int4(entries[a][2]) * Int4::load(from[2] + v);
        (Int4::load(to[a] + v) - shiftArithmetic(sum + Int4(1 << (shift - 1)), shift)).store(rest[a] + v);
      }
  }

  /*! Sets VertStep::matrix, and rotation with all other bits 0. */
  void write(VertStep& step) const {
    uint32_t bytes[3] = {0, 0, 0};
    for (int i = 0; i < 9; i++) bytes[i / 4] |= (uint32_t(entries[i / 3][i % 3]) & 255u) << (8 * (i % 4));
    step.matrix[0] = bytes[0];
    step.matrix[1] = bytes[1];
    step.rotation = scale << 16 | bytes[2] << 24;
  }

private:
  /*! Sets s[a][b] to the sum of residuals on axis a times residuals of the first step on axis b. */
  void sum(const int (*residuals)[3][paddedVertices], double s[3][3]) const {
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        double total = 0;
        for (uint32_t g = 0; g < groups; g++) {
          Float4 four = 0.0f;
          for (int v = 0; v < paddedVertices; v += 4)
            four = four + toFloat(Int4::load(residuals[g][a] + v)) * toFloat(Int4::load(first[g][b] + v));
          float lanes[4];
          four.store(lanes);
          total += double(lanes[0]) + lanes[1] + lanes[2] + lanes[3];
        }
        s[a][b] = total;
      }
  }

  /*! m: symmetric, and nearly singular if residuals are parallel. Eliminates (LDL^T), because cofactors would cancel.
   *  Sets `out` to 0 if m is not positive definite after rounding. */
  static void invert(const double m[3][3], double out[3][3]) {
    const double l10 = m[1][0] / m[0][0], l20 = m[2][0] / m[0][0], rest = m[2][1] - l20 * m[1][0];
    const double d1 = m[1][1] - l10 * m[1][0], l21 = rest / nonZero(d1), d2 = m[2][2] - l20 * m[2][0] - l21 * rest;
    for (int b = 0; b < 3; b++) {
      const double y0 = b == 0, y1 = double(b == 1) - l10 * y0, y2 = double(b == 2) - l20 * y0 - l21 * y1;
      out[2][b] = y2 / nonZero(d2);
      out[1][b] = y1 / nonZero(d1) - l21 * out[2][b];
      out[0][b] = y0 / m[0][0] - l10 * out[1][b] - l20 * out[2][b];
      if (!(d1 > 0 && d2 > 0)) out[0][b] = out[1][b] = out[2][b] = 0;
    }
  }

  const int (*first)[3][paddedVertices] = nullptr;
  uint32_t groups = 0;
  double inverse[3][3];
  int entries[3][3];
  uint32_t scale = 0;
};
}} // namespace cvert::CVERT_ISA
