// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "height_grid.h"

#include <cmath>

namespace programs::python {

HeightGrid::HeightGrid(const py::object& heights, Vec3d origin, double cellX, double cellY)
  : origin(origin),
    cellX(cellX),
    cellY(cellY) {
  py::array given = realNumbers(heights, "heights");
  const Shape shape = shapeOf(given);
  if (given.ndim() == 2) given = given.attr("reshape")(1, shape[0], shape[1]);
  if (given.ndim() != 3)
    throwValueError("heights", "has shape " + shapeText(shape) +
                                   ": expected (rows, columns), or (steps, rows, columns) for heights that move");
  if (given.shape(0) < 1 || given.shape(0) > 129)
    throwValueError("heights", "has " + std::to_string(given.shape(0)) + " time steps: expected 1 to 129");
  if (given.shape(1) < 2 || given.shape(2) < 2 || given.shape(1) > mostSamples || given.shape(2) > mostSamples)
    throwValueError("heights", "has shape " + shapeText(shape) + ": expected 2 to 65535 rows and columns" +
                                   ", see terrain() for larger rasters");
  array = py::array_t<float>::ensure(given); // keeps strides
  if (!array) throw py::error_already_set();
  const auto h = array.unchecked<3>();
  for (py::ssize_t step = 0; step < h.shape(0); step++)
    for (py::ssize_t row = 0; row < h.shape(1); row++)
      for (py::ssize_t column = 0; column < h.shape(2); column++)
        if (std::isinf(h(step, row, column)))
          throwValueError("heights", "row " + std::to_string(row) + ", column " + std::to_string(column) +
                                         " is infinite: expected 32-bit floats, or NaN for a missing sample");
}

std::string HeightGrid::description() const {
  return "grid of " + std::to_string(array.shape(1)) + " x " + std::to_string(array.shape(2)) + " heights";
}

CbvhError HeightGrid::setInput(CbvhSurface surface, std::vector<Vec3f>& scratch) const {
  const auto h = array.unchecked<3>();
  const size_t rows = size_t(h.shape(1)), columns = size_t(h.shape(2)), perStep = rows * columns;
  scratch.clear();
  scratch.reserve(perStep * size_t(h.shape(0)) + 1); // the library reads beyond the last vertex
  for (py::ssize_t step = 0; step < h.shape(0); step++)
    for (py::ssize_t row = 0; row < h.shape(1); row++)
      for (py::ssize_t column = 0; column < h.shape(2); column++)
        scratch.push_back({float(origin.x + cellX * double(column)), float(origin.y + cellY * double(row)),
                           float(origin.z + double(h(step, row, column)))});
  scratch.emplace_back();
  std::vector<const float*> starts;
  for (size_t step = 0; step < steps(); step++) starts.push_back(&scratch[step * perStep].x);
  return setGrid(surface, rows, columns, columns, {perStep, sizeof(Vec3f), starts.data(), steps(), startTime, endTime});
}

} // namespace programs::python
