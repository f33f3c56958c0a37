// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pybind11/pybind11.h>

#include <sstream>
#include <string>

namespace programs::python {

/* Issues a Python warning per line. Replaces bytes that are not UTF-8. Requires the interpreter's lock. */
inline void warn(const std::string& lines) {
  std::istringstream stream(lines);
  for (std::string line; std::getline(stream, line);)
    if (PyErr_WarnFormat(PyExc_UserWarning, 1, "%s", line.c_str()))
      throw pybind11::error_already_set(); // the user turned warnings into errors
}

} // namespace programs::python
