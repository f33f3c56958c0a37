// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdio>
#include <sstream>
#include <string>

namespace cbvh {

/* Lines of loadScene's, on stderr, after the program's name. */
inline void printWarnings(const char* program, const std::string& warnings)
{
  std::istringstream lines(warnings);
  for (std::string line; std::getline(lines, line);)
    std::fprintf(stderr, "%s: warning: %s\n", program, line.c_str());
}

} // namespace cbvh
