// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A grid of heights at equal distances. The heights stay in the caller's array; vertices exist only while the surface
 * is built. */

#include "arrays.h"
#include "geometry.h"

namespace programs::python {

/* Largest number of samples along a side of a grid: cbvh.h counts them in 16 bits. */
constexpr py::ssize_t mostSamples = 65535;

class HeightGrid : public SurfaceGeometry {
public:
  /* Requires shape (rows, columns) or (steps, rows, columns). Heights may be NaN, but not infinite. cellX, cellY:
   * from a column, or a row, to the next one. origin: of sample [0, 0]. */
  HeightGrid(const py::object& heights, Vec3d origin, double cellX, double cellY);

  size_t numPrimitives() const override { return 1; }
  unsigned steps() const override { return unsigned(array.shape(0)); }
  std::string description() const override;
  CbvhError setInput(CbvhSurface surface, std::vector<Vec3f>& scratch) const override;

private:
  py::array_t<float> array; // (steps, rows, columns), of any strides
  Vec3d origin;
  double cellX, cellY;
};

} // namespace programs::python
