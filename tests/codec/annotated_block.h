// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace cbvh::test {

// Returns the bytes of a page's annotated block, from rows "| offset | `bytes` | meaning |" of that section. Offsets
// must be consecutive.
inline std::vector<int> annotatedBytes(const std::string& page)
{
  std::ifstream file(page);
  std::vector<int> bytes;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.compare(0, 1, "#") == 0) inside = line == "## Annotated block";
    unsigned offset;
    if (!inside || std::sscanf(line.c_str(), "| %u | `", &offset) != 1) continue;
    EXPECT_EQ(offset, bytes.size()) << line;
    const size_t begin = line.find('`') + 1;
    std::istringstream row(line.substr(begin, line.find('`', begin) - begin));
    for (unsigned byte; row >> std::hex >> byte;) bytes.push_back(int(byte));
  }
  return bytes;
}

} // namespace cbvh::test
