// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Prints the warnings of loadScene, one per line. */

#include <cstdio>
#include <sstream>
#include <string>

namespace cbvh {

/* Adds a prefix to each line. */
inline std::string prefixLines(const std::string& prefix, const std::string& warnings)
{
  std::istringstream lines(warnings);
  std::string all;
  for (std::string line; std::getline(lines, line);)
    all += prefix + line + "\n";
  return all;
}

/* Prints warnings on stderr, prefixed with the program's name. */
inline void printWarnings(const std::string& program, const std::string& warnings)
{
  std::fputs(prefixLines(program + ": warning: ", warnings).c_str(), stderr);
}

} // namespace cbvh
