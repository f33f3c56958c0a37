// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Fits the affine map that predicts the vertices of a mesh block at a later time step from their positions at the first
 * step, by least squares (format/mesh_motion.h). Products and sums are not fused, so that all instruction sets encode
 * the same bytes. Positions must be finite. */

#include "../portable/language.h"
#include <cmath>

namespace cvert { inline namespace CVERT_ISA {
class AffineFit {
public:
  /*! Required before fit(), and again for each block. first: `count` vertices at the first step, at least 1. fit()
   *  reads them, too. */
  void setFirst(const float (*first)[3], uint32_t count) {
    this->first = first;
    this->count = count;
    mean(first, firstMean);
    double s[3][3];
    setProducts(first, firstMean, s);
    /* Factors s into L D L^T. L is `factor`, D is `diagonal`. If vertices lie nearly in a plane or on a line, an axis
     * may depend linearly on the axes before it: at most 1e-9 of the sum of all variances remains of its own. The map
     * does not use such an axis. */
    const double least = product(1e-9, s[0][0] + s[1][1] + s[2][2]);
    for (int a = 0; a < 3; a++) {
      diagonal[a] = s[a][a];
      for (int b = 0; b < a; b++) diagonal[a] -= product(product(factor[a][b], factor[a][b]), diagonal[b]);
      isUsed[a] = diagonal[a] > least;
      if (!isUsed[a]) diagonal[a] = 0;
      for (int c = a + 1; c < 3; c++) {
        double rest = s[c][a];
        for (int b = 0; b < a; b++) rest -= product(product(factor[c][b], factor[a][b]), diagonal[b]);
        factor[c][a] = isUsed[a] ? rest / diagonal[a] : 0;
      }
    }
  }

  /*! later: the same vertices at a later step. map: receives MeshStep::map. */
  void fit(const float (*later)[3], float map[3][4]) const {
    double laterMean[3], s[3][3];
    mean(later, laterMean);
    setProducts(later, laterMean, s);
    for (int a = 0; a < 3; a++) {
      double row[3] = {s[a][0], s[a][1], s[a][2]};
      solve(row);
      double summand = laterMean[a];
      for (int b = 0; b < 3; b++) {
        map[a][b] = normalOrZero(row[b]);
        summand -= product(double(map[a][b]), firstMean[b]);
      }
      map[a][3] = normalOrZero(summand);
    }
  }

private:
  /*! Rounds to a float. Returns 0 unless the magnitude is at least the smallest normal float, and below 3.4e38. */
  static float normalOrZero(double x) {
    return std::fabs(x) >= 1.1754943508222875e-38 && std::fabs(x) < 3.4e38 ? float(x) : 0.0f;
  }

  void mean(const float (*positions)[3], double out[3]) const {
    for (int k = 0; k < 3; k++) {
      out[k] = 0;
      for (uint32_t v = 0; v < count; v++) out[k] += double(positions[v][k]);
      out[k] /= count;
    }
  }

  /*! Sets s[a][b] to the sum over all vertices of (position on axis a) * (first position on axis b), both relative to
   *  their means. center: mean of the positions. */
  void setProducts(const float (*positions)[3], const double center[3], double s[3][3]) const {
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        s[a][b] = 0;
        for (uint32_t v = 0; v < count; v++)
          s[a][b] += product(double(positions[v][a]) - center[a], double(first[v][b]) - firstMean[b]);
      }
  }

  /*! Solves s y = x for the factored matrix s. x: replaced by y, which is 0 on unused axes. */
  void solve(double x[3]) const {
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < a; b++) x[a] -= product(factor[a][b], x[b]);
    for (int a = 0; a < 3; a++) x[a] = isUsed[a] ? x[a] / diagonal[a] : 0;
    for (int a = 2; a >= 0; a--)
      for (int b = a + 1; b < 3; b++) x[a] -= product(factor[b][a], x[b]);
  }

  const float (*first)[3] = nullptr;
  uint32_t count = 0;
  double firstMean[3], factor[3][3], diagonal[3];
  bool isUsed[3];
};
}} // namespace cvert::CVERT_ISA
