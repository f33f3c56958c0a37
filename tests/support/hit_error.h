// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The exact hit of a ray on a triangle, and first-order bounds on the rounding errors of three ways to compute it in
 * floats: our rule (docs/formats/rays.md), and Embree's Moeller-Trumbore and Pluecker tests. */

#include "support/surface_access.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>

namespace programs::test {

// Largest relative error of a float operation.
constexpr double unitRoundoff = 0x1p-24;

// Distance from |x| to the next float above it.
inline double ulpOf(float x) {
  const float size = std::fabs(x);
  return double(std::nextafter(size, INFINITY)) - size;
}

struct HitError {
  double t, u, v;
};

// Computed in double precision from the triangle's vertices.
class ExactTriangleHit {
public:
  double t, u, v;
  double weights[3]; // of the vertices; one of them is negative if the line misses the triangle
  double cosine;     // of the angle between ray and normal, not negative

  ExactTriangleHit(const RTCRay& ray, const CbvhTriangle& triangle) : triangle(triangle) {
    const float org[3] = {ray.org_x, ray.org_y, ray.org_z}, dir[3] = {ray.dir_x, ray.dir_y, ray.dir_z};
    const auto square = [](const double a[3]) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; };
    for (int k = 0; k < 3; k++) {
      D[k] = dir[k];
      for (int c = 0; c < 3; c++) d[c][k] = double(triangle.vertices[c][k]) - org[k];
    }
    double e[3], f[3], heightOfRay = 0;
    for (int k = 0; k < 3; k++) {
      e[k] = d[1][k] - d[0][k];
      f[k] = d[2][k] - d[0][k];
      E[k] = std::max({std::fabs(e[k]), std::fabs(f[k]), std::fabs(f[k] - e[k])});
      C[k] = std::max({std::fabs(d[0][k]), std::fabs(d[1][k]), std::fabs(d[2][k])});
    }
    den = 0;
    for (int k = 0; k < 3; k++) {
      n[k] = e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3];
      den += n[k] * D[k];
      heightOfRay += n[k] * d[0][k];
    }
    t = heightOfRay / den;
    cosine = std::fabs(den) / std::sqrt(square(n) * square(D));

    /* the ray as the z axis */
    kz = 0;
    for (int k = 1; k < 3; k++)
      if (std::fabs(D[k]) > std::fabs(D[kz])) kz = k;
    for (int c = 0; c < 3; c++)
      for (int i = 0; i < 2; i++) sheared[c][i] = d[c][axis(i)] - D[axis(i)] / D[kz] * d[c][kz];
    sum = 0;
    for (int c = 0; c < 3; c++) sum += weights[c] = side(c);
    for (double& w : weights) w /= sum;
    u = v = 0;
    for (int c = 0; c < 3; c++) {
      u += weights[c] * triangle.u[c];
      v += weights[c] * triangle.v[c];
    }
  }

  bool isMet() const { return std::min({weights[0], weights[1], weights[2]}) >= 0; }

  /* Bounds the errors of our rule.
   *
   * t is computed in double and rounded once: half an ulp, plus less than half an ulp for the error of the doubles, if
   * the ray does not lie in the plane.
   *
   * A sheared coordinate x = d1 - S dz, with S = D1 (1/Dz), has the rounding errors of the difference d1; of dz, 1/Dz,
   * S and the product S dz; and of the last difference. A side a.x b.y - a.y b.x has the errors of its factors, of both
   * products and of the difference. A weight is a side divided by the sum of three sides. A parameter adds at most 8
   * operations on numbers up to the larger of 1 and the parameter: 1 - a - b, quad + a, the division by the number of
   * quads, + corner, and the rounding of the vertices' parameters. */
  HitError oursBound() const {
    double sideErrors[3], allSides = 0;
    for (int c = 0; c < 3; c++) {
      const double *p = sheared[(c + 1) % 3], *q = sheared[(c + 2) % 3];
      const ShearError ofP = shearError((c + 1) % 3), ofQ = shearError((c + 2) % 3);
      const double *pe = ofP.at, *qe = ofQ.at;
      const double products = std::fabs(p[0] * q[1]) + std::fabs(p[1] * q[0]);
      sideErrors[c] = pe[0] * std::fabs(q[1]) + qe[1] * std::fabs(p[0]) + pe[1] * std::fabs(q[0]) +
                      qe[0] * std::fabs(p[1]) + unitRoundoff * (products + std::fabs(side(c)));
      allSides += sideErrors[c];
    }
    double weightErrors = 0;
    for (int c = 0; c < 3; c++)
      weightErrors +=
          (sideErrors[c] + std::fabs(weights[c]) * (allSides + 2 * unitRoundoff * std::fabs(sum))) / std::fabs(sum) +
          unitRoundoff * std::fabs(weights[c]);
    return bound(ulpOf(float(t)), weightErrors, 8);
  }

  /* Bounds the errors of both of Embree's tests. |abc| is the permanent of absolute values. C is the largest absolute
   * value of vertex - org, and E of the edges, on each axis.
   *
   * Moeller-Trumbore: U = (C x D).E2 has 7 roundings: C, E2, two in the cross product, three in the dot product. So has
   * den = (E1 x E2).D, and |EED| <= 2 |CED|. T = (E1 x E2).C has 8.
   * Pluecker: U = (e x (a + b)).D of a, b = vertex - org has the same 7 roundings of twice the size. In addition, the
   * rounding of a and b moves the vertices by C u, which adds 2 |CED| u. The sum of three sides has three times the
   * error. In total a weight has 9, the sum 27. T has 8: the moved vertices move the plane by at most |EEC| u.
   * 1/den has an error of at most 2 ulps; so has the reciprocal of the number of a grid's quads.
   *
   * vertexError: distances on each axis by which Embree's vertices may differ from the triangle's. parameterError: the
   * same for u and v of the vertices. */
  HitError embreesBound(const double vertexError[3], double parameterError) const {
    const double moved = permanent(vertexError, E, D);
    double weightErrors = 0, plane = 0;
    for (double w : weights)
      weightErrors += (unitRoundoff * (9 + 27 * std::fabs(w)) * permanent(C, E, D) + (2 + 6 * std::fabs(w)) * moved) /
                          std::fabs(den) +
                      5 * unitRoundoff * std::fabs(w);
    for (int k = 0; k < 3; k++) plane += std::fabs(n[k]) * vertexError[k];
    const double rounding = unitRoundoff * (8 * permanent(E, E, C) + 7 * std::fabs(t) * permanent(E, E, D));
    const double tError = (rounding + plane) / std::fabs(den) + 5 * unitRoundoff * std::fabs(t);
    HitError error = bound(tError, weightErrors, 16);
    error.u += parameterError;
    error.v += parameterError;
    return error;
  }

private:
  struct ShearError {
    double at[2];
  };

  int axis(int i) const { return (kz + 1 + i) % 3; }

  double side(int c) const {
    const double *p = sheared[(c + 1) % 3], *q = sheared[(c + 2) % 3];
    return p[0] * q[1] - p[1] * q[0];
  }

  ShearError shearError(int c) const {
    ShearError error;
    for (int i = 0; i < 2; i++) {
      const double product = std::fabs(D[axis(i)] / D[kz] * d[c][kz]);
      error.at[i] = unitRoundoff * (std::fabs(d[c][axis(i)]) + 4 * product + std::fabs(sheared[c][i]));
    }
    return error;
  }

  static double permanent(const double a[3], const double b[3], const double c[3]) {
    double sum = 0;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        if (i != j) sum += std::fabs(a[i] * b[j] * c[3 - i - j]);
    return sum;
  }

  // operations: number of roundings after the weights
  HitError bound(double ofT, double weightErrors, double operations) const {
    const auto parameter = [&](const float at[3], double value) {
      const double span = double(std::max({at[0], at[1], at[2]})) - std::min({at[0], at[1], at[2]});
      return weightErrors * span + operations * unitRoundoff * std::max(1.0, std::fabs(value));
    };
    return {ofT, parameter(triangle.u, u), parameter(triangle.v, v)};
  }

  const CbvhTriangle triangle;
  double d[3][3], D[3], E[3], C[3], n[3], den;
  int kz;
  double sheared[3][2], sum;
};

} // namespace programs::test
