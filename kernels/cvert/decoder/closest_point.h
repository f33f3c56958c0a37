// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The point of a triangle that is closest to a given point, in double precision. Vertices are floats, so that their
 * differences have no or little rounding. The closest point is that of an edge, or the projection to the plane. No
 * product is fused with a sum: results do not depend on the instruction set. */

#include "../portable/language.h"

namespace cvert { inline namespace CVERT_ISA {

/*! squared: of the distance; infinite if a vertex is not finite, or two are equal. w1, w2: barycentric weights of the
 *  second and third vertex. */
struct PointOfTriangle {
  double squared, w1, w2;
};

namespace closest_point {
struct Vector {
  double x, y, z;
};
inline Vector operator-(const Vector& a, const Vector& b) { return Vector{a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector along(const Vector& a, double t, const Vector& b) {
  return Vector{a.x + product(t, b.x), a.y + product(t, b.y), a.z + product(t, b.z)};
}
inline double dot(const Vector& a, const Vector& b) {
  return product(a.x, b.x) + product(a.y, b.y) + product(a.z, b.z);
}
inline Vector cross(const Vector& a, const Vector& b) {
  return Vector{product(a.y, b.z) - product(a.z, b.y), product(a.z, b.x) - product(a.x, b.z),
                product(a.x, b.y) - product(a.y, b.x)};
}

/*! Position, 0 to 1, of the point of an edge that is closest to the origin. */
inline double positionInEdge(const Vector& begin, const Vector& edge) {
  const double t = -dot(begin, edge), length = dot(edge, edge);
  return t > 0 && length > 0 ? std::fmin(t / length, 1.0) : 0.0;
}
} // namespace closest_point

/*! vertices: [axis][vertex]. Of several equally close points, returns any. */
inline PointOfTriangle closestPointOfTriangle(const double p[3], const double (&vertices)[3][3]) {
  using namespace closest_point;
  double sum = 0;
  for (int k = 0; k < 3; k++) sum += vertices[k][0] + vertices[k][1] + vertices[k][2];
  PointOfTriangle best = {std::numeric_limits<double>::infinity(), 0, 0};
  if (!std::isfinite(sum)) return best;
  const Vector origin = {p[0], p[1], p[2]};
  auto vertex = [&](int i) { return Vector{vertices[0][i], vertices[1][i], vertices[2][i]}; };
  const Vector a = vertex(0) - origin, b = vertex(1) - origin, ab = vertex(1) - vertex(0), ac = vertex(2) - vertex(0),
               bc = vertex(2) - vertex(1);
  if (dot(ab, ab) == 0 || dot(ac, ac) == 0 || dot(bc, bc) == 0) return best;
  auto consider = [&](double squared, double w1, double w2) {
    if (squared < best.squared) best = PointOfTriangle{squared, w1, w2};
  };
  auto considerEdge = [&](const Vector& begin, const Vector& edge, double t, double w1, double w2) {
    const Vector at = along(begin, t, edge);
    consider(dot(at, at), w1, w2);
  };
  const double tab = positionInEdge(a, ab), tac = positionInEdge(a, ac), tbc = positionInEdge(b, bc);
  considerEdge(a, ab, tab, tab, 0);
  considerEdge(a, ac, tac, 0, tac);
  considerEdge(b, bc, tbc, 1 - tbc, tbc);
  const Vector n = cross(ab, ac);
  const double nn = dot(n, n);
  if (nn > 0) {
    const double w1 = dot(n, cross(ac, a)) / nn, w2 = dot(n, cross(a, ab)) / nn, height = dot(a, n);
    if (w1 >= 0 && w2 >= 0 && w1 + w2 <= 1) consider(product(height / nn, height), w1, w2);
  }
  return best;
}

}} // namespace cvert::CVERT_ISA
