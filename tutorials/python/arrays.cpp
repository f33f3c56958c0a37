// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "arrays.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace programs::python {
namespace {

using Integers = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;

/* `kinds` are NumPy's letters of accepted types; `expected` is for messages. */
py::array numbers(const py::object& value, const std::string& argument, const std::string& kinds,
                  const std::string& expected) {
  if (py::module_::import("numpy.ma").attr("is_masked")(value).cast<bool>())
    throwValueError(argument, "has masked elements: expected an array without a mask");
  py::array array;
  try {
    array = py::module_::import("numpy").attr("asarray")(value);
  } catch (py::error_already_set& e) {
    if (!e.matches(PyExc_ValueError) && !e.matches(PyExc_TypeError)) throw;
    throw py::type_error(argument + ": is not an array of " + expected + ": " + std::string(py::str(e.value())));
  }
  /* NumPy converts an empty list to an array of floats. */
  if (kinds.find(array.dtype().kind()) == std::string::npos && array.size() > 0)
    throw py::type_error(argument + ": is an array of " + std::string(py::str(array.dtype())) + ": expected " +
                         expected);
  return array;
}

void requireShape(const py::array& array, const std::string& argument, py::ssize_t width) {
  const bool rows = width > 1;
  if (array.size() == 0 && array.ndim() == 1) return; // an empty list
  if (array.ndim() != (rows ? 2 : 1) || (rows && array.shape(1) != width))
    throwValueError(argument, "has shape " + shapeText(shapeOf(array)) + ": expected " +
                                  (rows ? "(n, " + std::to_string(width) + ")" : std::string("(n,)")));
}

template<typename Vector>
std::vector<Vector> vectors(const py::object& value, const std::string& argument) {
  constexpr py::ssize_t width = sizeof(Vector) / sizeof(float);
  const Floats array = floats(value, argument);
  requireShape(array, argument, width);
  for (py::ssize_t i = 0; i < array.size(); i++)
    if (!std::isfinite(array.data()[i]))
      throwValueError(argument, "row " + std::to_string(i / width) + " is not finite: expected finite numbers");
  std::vector<Vector> result(size_t(array.size() / width));
  if (!result.empty()) std::copy(array.data(), array.data() + array.size(), &result[0].x);
  return result;
}

} // namespace

std::string shapeText(const Shape& shape) { return std::string(py::str(py::tuple(py::cast(shape)))); }

Shape shapeOf(const py::array& array) { return Shape(array.shape(), array.shape() + array.ndim()); }

void throwValueError(const std::string& argument, const std::string& why) {
  throw py::value_error(argument + ": " + why);
}

py::array realNumbers(const py::object& value, const std::string& argument) {
  return numbers(value, argument, "fiub", "real numbers");
}

py::array integers(const py::object& value, const std::string& argument) {
  return numbers(value, argument, "iu", "integers");
}

Floats floats(const py::object& value, const std::string& argument) { return Floats(realNumbers(value, argument)); }

std::vector<float> floatVector(const py::object& value, const std::string& argument) {
  const Floats array = floats(value, argument);
  requireShape(array, argument, 1);
  return std::vector<float>(array.data(), array.data() + array.size());
}

std::vector<Vec2f> vec2Vector(const py::object& value, const std::string& argument) {
  return vectors<Vec2f>(value, argument);
}

std::vector<Vec3f> vec3Vector(const py::object& value, const std::string& argument) {
  return vectors<Vec3f>(value, argument);
}

Vec3d vec3d(const py::object& value, const std::string& argument) {
  const Doubles array(realNumbers(value, argument));
  if (shapeOf(array) != Shape{3})
    throwValueError(argument, "has shape " + shapeText(shapeOf(array)) + ": expected (3,)");
  const Vec3d v{array.data()[0], array.data()[1], array.data()[2]};
  if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
    throwValueError(argument, "is not finite: expected finite numbers");
  return v;
}

Vec3f vec3(const py::object& value, const std::string& argument) {
  const Vec3d v = vec3d(value, argument);
  const Vec3f rounded{float(v.x), float(v.y), float(v.z)};
  if (!isFinite(rounded)) throwValueError(argument, "is not finite: expected finite numbers");
  return rounded;
}

std::vector<unsigned> indices(const py::object& value, const std::string& argument, size_t limit, Shape& shape,
                              std::optional<unsigned> none) {
  const py::array given = integers(value, argument);
  const bool isUnsigned = given.dtype().kind() == 'u';
  const Integers array(given);
  shape = shapeOf(array);
  std::vector<unsigned> result(static_cast<size_t>(array.size()));
  for (size_t i = 0; i < result.size(); i++) {
    const int64_t index = array.data()[i];
    if ((index < 0 || uint64_t(index) >= limit) && !(none && index == *none))
      throwValueError(argument, "contains " + (isUnsigned ? std::to_string(uint64_t(index)) : std::to_string(index)) +
                                    ": expected 0 to " + std::to_string(int64_t(limit) - 1));
    result[i] = unsigned(index);
  }
  return result;
}

std::vector<unsigned> indexVector(const py::object& value, const std::string& argument, size_t limit) {
  Shape shape;
  const std::vector<unsigned> result = indices(value, argument, limit, shape);
  if (shape.size() != 1) throwValueError(argument, "has shape " + shapeText(shape) + ": expected (n,)");
  return result;
}

std::vector<std::pair<unsigned, unsigned>> indexPairs(const py::object& value, const std::string& argument,
                                                      size_t limit) {
  Shape shape;
  const std::vector<unsigned> all = indices(value, argument, limit, shape);
  if (!all.empty() && (shape.size() != 2 || shape[1] != 2))
    throwValueError(argument, "has shape " + shapeText(shape) + ": expected (n, 2)");
  std::vector<std::pair<unsigned, unsigned>> result;
  for (size_t i = 0; i < all.size(); i += 2) result.emplace_back(all[i], all[i + 1]);
  return result;
}

size_t choice(const std::string& word, const std::string& argument, const std::vector<std::string>& words) {
  const auto found = std::find(words.begin(), words.end(), word);
  if (found != words.end()) return size_t(found - words.begin());
  std::string expected;
  for (size_t i = 0; i < words.size(); i++)
    expected += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + ("'" + words[i] + "'");
  throwValueError(argument, "is '" + word + "': expected " + expected);
}

py::str stringOf(const std::string& text) {
  return py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(text.data(), py::ssize_t(text.size()), "surrogateescape"));
}

py::array_t<float> arrayOf(Vec3f v) {
  const float components[3] = {v.x, v.y, v.z};
  return arrayOf<float>({3}, [&](size_t i) { return components[i]; });
}

py::array_t<float> arrayOf(const Box3f& box) {
  const Vec3f corners[2] = {box.lower, box.upper};
  return arrayOf<float>({2, 3}, [&](size_t i) { return (&corners[0].x)[i]; });
}

} // namespace programs::python
