// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts anything that NumPy accepts as an array of numbers to vectors of common/, and back. Invalid arguments
 * raise TypeError or ValueError with the argument's name. */

#include "basics/vec.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace programs::python {

namespace py = pybind11;

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Shape = std::vector<py::ssize_t>;

/* "(4, 3)" */
std::string shapeText(const Shape& shape);
Shape shapeOf(const py::array& array);

[[noreturn]] void throwValueError(const std::string& argument, const std::string& why);

/* --- arguments ---------------------------------------------------------------- */

/* Accepts any shape and any type of real numbers. Rejects masked elements, as do the functions below. */
py::array realNumbers(const py::object& value, const std::string& argument);
py::array integers(const py::object& value, const std::string& argument);
Floats floats(const py::object& value, const std::string& argument);

/* Shapes (n,), (n, 2) and (n, 3). The last two must be finite. */
std::vector<float> floatVector(const py::object& value, const std::string& argument);
std::vector<Vec2f> vec2Vector(const py::object& value, const std::string& argument);
std::vector<Vec3f> vec3Vector(const py::object& value, const std::string& argument);

/* Require shape (3,), finite. */
Vec3f vec3(const py::object& value, const std::string& argument);
Vec3d vec3d(const py::object& value, const std::string& argument);

/* Requires 0 to limit - 1, or `none`. Writes the argument's shape to `shape`. */
std::vector<unsigned> indices(const py::object& value, const std::string& argument, size_t limit, Shape& shape,
                              std::optional<unsigned> none = {});

/* Shapes (n,) and (n, 2). */
std::vector<unsigned> indexVector(const py::object& value, const std::string& argument, size_t limit);
std::vector<std::pair<unsigned, unsigned>> indexPairs(const py::object& value, const std::string& argument,
                                                      size_t limit);

/* Index of `word` in `words`. */
size_t choice(const std::string& word, const std::string& argument, const std::vector<std::string>& words);

/* --- results ------------------------------------------------------------------ */

/* Decodes UTF-8. Other bytes, as in names of files, become surrogates, as in os.fsdecode. */
py::str stringOf(const std::string& text);

/* Returns a read-only array of data that belongs to `owner`. Keeps `owner` alive. */
template<typename T>
py::array view(const T* data, const Shape& shape, const Shape& strides, const py::handle& owner) {
  py::array array(py::dtype::of<T>(), shape, strides, data, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

/* For vectors whose elements consist of T only: shape (n,) or (n, width). */
template<typename T, typename Element>
py::array view(const std::vector<Element>& elements, const py::handle& owner) {
  static_assert(sizeof(Element) % sizeof(T) == 0);
  const py::ssize_t n = py::ssize_t(elements.size()), width = sizeof(Element) / sizeof(T);
  const T* const data = reinterpret_cast<const T*>(elements.data());
  return width == 1 ? view(data, {n}, {sizeof(T)}, owner)
                    : view(data, {n, width}, {py::ssize_t(sizeof(Element)), sizeof(T)}, owner);
}

/* Element i is function(i). */
template<typename T, typename Function>
py::array_t<T> arrayOf(const Shape& shape, const Function& function) {
  py::array_t<T> array(shape);
  T* const data = array.mutable_data();
  for (py::ssize_t i = 0; i < array.size(); i++) data[i] = function(size_t(i));
  return array;
}

/* Shapes (3,) and (2, 3): lower and upper corner. */
py::array_t<float> arrayOf(Vec3f v);
py::array_t<float> arrayOf(const Box3f& box);

} // namespace programs::python
