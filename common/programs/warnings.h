// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What loadScene warns of, a line each. */

#include <cstdio>
#include <sstream>
#include <string>

namespace cbvh {

/* Each line after some words. */
inline std::string linesAfter(const std::string& words, const std::string& warnings)
{
  std::istringstream lines(warnings);
  std::string all;
  for (std::string line; std::getline(lines, line);)
    all += words + line + "\n";
  return all;
}

/* On stderr, after the program's name. */
inline void printWarnings(const std::string& program, const std::string& warnings)
{
  std::fputs(linesAfter(program + ": warning: ", warnings).c_str(), stderr);
}

} // namespace cbvh
