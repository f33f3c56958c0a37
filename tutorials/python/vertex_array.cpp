// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "vertex_array.h"

#include <unistd.h>

#include <cmath>
#include <cstdint>

namespace programs::python {
namespace {

constexpr py::ssize_t most = 129; // time steps in Embree

/* The axes (steps, rows, columns, 3) of an array with fewer axes. */
py::array withAllAxes(const py::array& array, int dimensions) {
  py::object result = array;
  if (dimensions == 1)
    result =
        result[py::make_tuple(py::ellipsis(), py::none(), py::slice(0, INTPTR_MAX, 1), py::slice(0, INTPTR_MAX, 1))];
  if (array.ndim() == dimensions + 1) result = result[py::make_tuple(py::none(), py::ellipsis())];
  return result;
}

/* Index of an element, without the axes that withAllAxes adds. */
std::string placeText(py::ssize_t step, py::ssize_t row, py::ssize_t column, const py::array& given, int dimensions) {
  std::string text;
  if (given.ndim() > dimensions + 1) text = "time step " + std::to_string(step) + ", ";
  if (dimensions == 1) return text + "row " + std::to_string(column);
  return text + "row " + std::to_string(row) + ", column " + std::to_string(column);
}

/* The library reads 4 bytes after the last vertex. They are readable if they are in the page of its last byte. */
bool isReadableBeyond(const char* end) {
  static const uintptr_t page = uintptr_t(sysconf(_SC_PAGESIZE));
  return (uintptr_t(end) - 1) / page == (uintptr_t(end) + 3) / page;
}

/* True if the library can read all steps of an array with four axes. */
bool isReadable(const py::array& a) {
  if (!py::isinstance<py::array_t<float>>(a) || (a.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) == 0)
    return false;
  const py::ssize_t column = a.strides(2), row = a.strides(1), columns = a.shape(2), rows = a.shape(1);
  if (a.strides(3) != sizeof(float) || column < py::ssize_t(3 * sizeof(float)) || column % sizeof(float) != 0)
    return false;
  if (rows > 1 && (row < column * columns || row % column != 0)) return false;
  for (py::ssize_t step = 0; step < a.shape(0); step++) {
    const char* const data = static_cast<const char*>(a.data()) + step * a.strides(0);
    if (!isReadableBeyond(data + (rows - 1) * row + (columns - 1) * column + 3 * sizeof(float))) return false;
  }
  return true;
}

} // namespace

VertexArray::VertexArray(const py::object& value, const std::string& argument, int dimensions) {
  const py::array given = realNumbers(value, argument);
  if ((given.ndim() != dimensions + 1 && given.ndim() != dimensions + 2) || given.shape(given.ndim() - 1) != 3) {
    const std::string axes = dimensions == 1 ? "n, 3)" : "rows, columns, 3)";
    throwValueError(argument, "has shape " + shapeText(shapeOf(given)) + ": expected (" + axes + ", or (steps, " +
                                  axes + " for vertices that move");
  }
  const py::array array = withAllAxes(given, dimensions);
  if (array.shape(0) < 1 || array.shape(0) > most)
    throwValueError(argument,
                    "has " + std::to_string(array.shape(0)) + " time steps: expected 1 to " + std::to_string(most));
  numRows = size_t(array.shape(1));
  numColumns = size_t(array.shape(2));
  if (numRows * numColumns >= UINT32_MAX)
    throwValueError(argument,
                    "has " + std::to_string(numRows * numColumns) + " vertices: expected less than 2**32 - 1");
  if (array.size() > 0 && isReadable(array)) use(array);
  else copy(array);
  for (size_t step = 0; step < pointers.size(); step++)
    for (size_t row = 0; row < numRows; row++)
      for (size_t column = 0; column < numColumns; column++) {
        const float* const v = pointers[step] + (row * verticesPerRow + column) * stride / sizeof(float);
        if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2]))
          throwValueError(argument,
                          placeText(py::ssize_t(step), py::ssize_t(row), py::ssize_t(column), given, dimensions) +
                              " is not finite: expected finite numbers, as 32-bit floats");
      }
}

void VertexArray::use(const py::array& array) {
  kept = array;
  stride = size_t(array.strides(2));
  verticesPerRow = numRows > 1 ? size_t(array.strides(1)) / stride : numColumns;
  for (py::ssize_t step = 0; step < array.shape(0); step++)
    pointers.push_back(
        reinterpret_cast<const float*>(static_cast<const char*>(array.data()) + step * array.strides(0)));
}

void VertexArray::copy(const py::array& array) {
  const Floats converted(array);
  copied.assign(converted.data(), converted.data() + converted.size());
  copied.push_back(0); // read after the last vertex
  stride = 3 * sizeof(float);
  verticesPerRow = numColumns;
  for (py::ssize_t step = 0; step < array.shape(0); step++)
    pointers.push_back(copied.data() + size_t(step) * numRows * numColumns * 3);
}

CbvhVertices VertexArray::vertices(float startTime, float endTime) const {
  CbvhVertices result = CbvhVertices();
  result.numVertices = (numRows - 1) * verticesPerRow + numColumns;
  result.stride = stride;
  result.steps = pointers.data();
  result.numSteps = steps();
  result.startTime = startTime;
  result.endTime = endTime;
  return result;
}

} // namespace programs::python
