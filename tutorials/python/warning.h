// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pybind11/pybind11.h>

#include <sstream>
#include <string>

namespace cbvh::python {

/* One warning per line. Requires the interpreter's lock. */
inline void warn(const std::string& lines)
{
  std::istringstream stream(lines);
  for (std::string line; std::getline(stream, line);)
    if (PyErr_WarnEx(PyExc_UserWarning, line.c_str(), 1))
      throw pybind11::error_already_set(); // the user turned warnings into errors
}

} // namespace cbvh::python
