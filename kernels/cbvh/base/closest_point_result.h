// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts the closest point of a triangle to the result of a query. */

#include "codec_names.h"
#include "point_on_surface.h"
#include "../../cvert/decoder/closest_point.h"
#include "../../cvert/rule/rule.h"

namespace embree { namespace cbvh { inline namespace CVERT_ISA {
/*! A number at a point of a triangle, from the numbers at its vertices. */
inline float interpolated(const PointOfTriangle& at, double a, double b, double c) {
  return float(a + product(at.w1, b - a) + product(at.w2, c - a));
}

/*! Sets position, distance and normal. */
inline void setPoint(const PointOfTriangle& at, const WideTriangle<double>& triangle, PointOnSurface& point) {
  const WideNormal<double> normal = normalOf(triangle);
  for (int k = 0; k < 3; k++) {
    point.p[k] = interpolated(at, triangle.at[k][0], triangle.at[k][1], triangle.at[k][2]);
    point.Ng[k] = float(normal.at[k]);
  }
  point.distance = float(std::sqrt(at.squared));
}
}}} // namespace embree::cbvh::CVERT_ISA
