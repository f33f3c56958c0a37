// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "ray_arrays.h"

namespace programs::python {
namespace {

constexpr int readable = py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_;
using ReadableFloats = py::array_t<float, readable>;
using ReadableDoubles = py::array_t<double, readable>;

py::tuple tupleOf(const Shape& shape) { return py::tuple(py::cast(shape)); }

size_t numElements(const Shape& shape) {
  size_t n = 1;
  for (const py::ssize_t extent : shape) n *= size_t(extent);
  return n;
}

py::array broadcast(const py::array& array, const Shape& shape) {
  return py::module_::import("numpy").attr("broadcast_to")(array, tupleOf(shape));
}

/* Of origins, directions, tnear, tfar and time. */
Shape broadcastShape(const Shape (&shapes)[5]) {
  Shape result;
  try {
    const py::object shape = py::module_::import("numpy").attr("broadcast_shapes")(
        tupleOf(shapes[0]), tupleOf(shapes[1]), tupleOf(shapes[2]), tupleOf(shapes[3]), tupleOf(shapes[4]));
    for (const py::handle& extent : shape) result.push_back(extent.cast<py::ssize_t>());
  } catch (py::error_already_set& e) {
    if (!e.matches(PyExc_ValueError)) throw;
    throw py::value_error("origins of " + shapeText(shapes[0]) + " points, directions of " + shapeText(shapes[1]) +
                          " vectors, tnear of shape " + shapeText(shapes[2]) + ", tfar of shape " +
                          shapeText(shapes[3]) + " and time of shape " + shapeText(shapes[4]) +
                          ": expected shapes that can be broadcast to one shape");
  }
  return result;
}

/* Copies the times: they are checked here, and other Python threads may change the array before it is read. */
Floats readTimes(const py::object& time) {
  const Floats given(realNumbers(time, "time"));
  const Floats copy(shapeOf(given), given.data());
  for (py::ssize_t i = 0; i < copy.size(); i++) requireTime(copy.data()[i]);
  return copy;
}

} // namespace

RayColumn::RayColumn(const py::array& array, const Shape& shape, size_t width) {
  const bool isOne = size_t(array.size()) == width;
  const py::array given = isOne ? array : broadcast(array, shape);
  isDouble = !py::isinstance<py::array_t<float>>(given);
  owner = isDouble ? py::array(ReadableDoubles(given)) : py::array(ReadableFloats(given));
  data = owner.data();
  step = isOne ? 0 : width;
}

std::vector<Ray> RayArrays::rays() const {
  std::vector<Ray> result(count);
  for (size_t i = 0; i < count; i++) result[i] = ray(i);
  return result;
}

RayArrays readRays(const py::object& origins, const py::object& directions, const py::object& tnear,
                   const py::object& tfar, const py::object& time) {
  const py::array o = realNumbers(origins, "origins"), d = realNumbers(directions, "directions");
  const py::array n = realNumbers(tnear, "tnear"), f = realNumbers(tfar, "tfar"), m = readTimes(time);
  const Shape shape = broadcastShape(
      {shapeOfVectors(o, "origins"), shapeOfVectors(d, "directions"), shapeOf(n), shapeOf(f), shapeOf(m)});
  Shape vectors = shape;
  vectors.push_back(3);
  return {shape,
          numElements(shape),
          RayColumn(o, vectors, 3),
          RayColumn(d, vectors, 3),
          RayColumn(n, shape, 1),
          RayColumn(f, shape, 1),
          RayColumn(m, shape, 1)};
}

RayArrays readRays(const py::object& origins, const py::object& directions) {
  return readRays(origins, directions, py::float_(0.0), py::float_(INFINITY), py::float_(0.0));
}

void requireTime(float time) {
  if (!(time >= 0.0f && time <= 1.0f)) throwValueError("time", "is " + std::to_string(time) + ": expected 0 to 1");
}

Shape shapeOfVectors(const py::array& array, const std::string& argument) {
  Shape shape = shapeOf(array);
  if (shape.empty() || shape.back() != 3)
    throwValueError(argument, "has shape " + shapeText(shape) + ": expected (..., 3)");
  shape.pop_back();
  return shape;
}

} // namespace programs::python
