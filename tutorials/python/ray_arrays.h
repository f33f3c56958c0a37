// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays in NumPy arrays, which threads read without Python. Shapes exclude the last axis, x, y and z. */

#include "arrays.h"

#include "tracing/ray.h"

#include <vector>

namespace programs::python {

/* An argument that was broadcast to a shape. Arrays of 32 and 64-bit floats are read where they are if they are
 * contiguous and have that shape, or one value for all rays; others are converted. */
class RayColumn {
public:
  RayColumn() = default;

  /* `width` is 3 for vectors, which are the last axis of `shape`, otherwise 1. */
  RayColumn(const py::array& array, const Shape& shape, size_t width);

  /* Element i in C order. */
  template<typename T>
  T at(size_t i) const {
    return isDouble ? T(*place<double>(i)) : T(*place<float>(i));
  }

  template<typename T>
  Vec3<T> vectorAt(size_t i) const {
    return isDouble ? vector<T>(place<double>(i)) : vector<T>(place<float>(i));
  }

private:
  template<typename Stored>
  const Stored* place(size_t i) const {
    return static_cast<const Stored*>(data) + i * step;
  }

  template<typename T, typename Stored>
  static Vec3<T> vector(const Stored* v) {
    return {T(v[0]), T(v[1]), T(v[2])};
  }

  py::array owner; // of the data
  const void* data = nullptr;
  bool isDouble = false;
  size_t step = 0; // 0: all rays have the same value
};

struct RayArrays {
  Shape shape;
  size_t count = 0;
  RayColumn origins, directions, tnear, tfar, time;

  /* Ray i in C order, rounded to 32 bits. */
  Ray ray(size_t i) const {
    return {origins.vectorAt<float>(i), tnear.at<float>(i), directions.vectorAt<float>(i), tfar.at<float>(i),
            time.at<float>(i)};
  }
  std::vector<Ray> rays() const;
};

/* Arguments as for Scene.intersect, broadcast by NumPy's rules. The arrays must not change while they are read. Raises
 * ValueError and TypeError. */
RayArrays readRays(const py::object& origins, const py::object& directions, const py::object& tnear,
                   const py::object& tfar, const py::object& time);
RayArrays readRays(const py::object& origins, const py::object& directions);

/* Raises ValueError unless the time is from 0 to 1. */
void requireTime(float time);

/* The shape without the last axis. Raises ValueError unless that is 3. */
Shape shapeOfVectors(const py::array& array, const std::string& argument);

} // namespace programs::python
