// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts JSON to Python objects. Names stay the same. */

#include <nlohmann/json.hpp>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <string>

namespace programs::python {

template<typename Json>
pybind11::object objectOf(const Json& json) {
  namespace py = pybind11;
  if (json.is_object()) {
    py::dict dict;
    for (const auto& item : json.items()) dict[py::str(item.key())] = objectOf(item.value());
    return dict;
  }
  if (json.is_array()) {
    py::list list;
    for (const Json& element : json) list.append(objectOf(element));
    return list;
  }
  if (json.is_string()) return py::str(json.template get<std::string>());
  if (json.is_boolean()) return py::bool_(json.template get<bool>());
  if (json.is_number_unsigned()) return py::int_(json.template get<uint64_t>());
  if (json.is_number_integer()) return py::int_(json.template get<int64_t>());
  if (json.is_number()) return py::float_(json.template get<double>());
  return py::none();
}

} // namespace programs::python
