// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Warnings of loadScene, one per line. */

#include <cstdio>
#include <sstream>
#include <string>

namespace cbvh {

inline std::string prefixLines(const std::string& prefix, const std::string& warnings)
{
  std::istringstream lines(warnings);
  std::string all;
  for (std::string line; std::getline(lines, line);)
    all += prefix + line + "\n";
  return all;
}

inline void printWarnings(const std::string& program, const std::string& warnings)
{
  std::fputs(prefixLines(program + ": warning: ", warnings).c_str(), stderr);
}

} // namespace cbvh
