// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices in an array of NumPy, for the structs of cbvh.h. The array is used as it is, without a copy, if it holds
 * float32 in an order that the library reads. */

#include "arrays.h"

#include <embree3/cbvh.h>

#include <vector>

namespace programs::python {

class VertexArray {
public:
  /* Requires shape (n, 3), or (rows, columns, 3) for `dimensions` = 2, and finite numbers. One more axis in front holds
   * time steps. */
  VertexArray(const py::object& value, const std::string& argument, int dimensions);

  /* Rows is 1 if there is one dimension. */
  size_t rows() const { return numRows; }
  size_t columns() const { return numColumns; }
  unsigned steps() const { return unsigned(pointers.size()); }

  /* Number of vertices from one row to the next. */
  size_t rowStride() const { return verticesPerRow; }

  /* Refers to the object and to its array. */
  CbvhVertices vertices(float startTime, float endTime) const;

private:
  void use(const py::array& array);
  void copy(const py::array& array);

  py::array kept;                     // its data, or
  std::vector<float> copied;          // a copy
  std::vector<const float*> pointers; // one per time step
  size_t numRows = 1, numColumns = 0, verticesPerRow = 0, stride = 0;
};

} // namespace programs::python
