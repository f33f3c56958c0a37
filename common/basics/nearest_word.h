// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace programs {

inline size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> costs(b.size() + 1), previous(b.size() + 1);
  for (size_t j = 0; j < costs.size(); j++) costs[j] = j;
  for (size_t i = 1; i <= a.size(); i++) {
    costs.swap(previous);
    costs[0] = i;
    for (size_t j = 1; j < costs.size(); j++)
      costs[j] = std::min({previous[j] + 1, costs[j - 1] + 1, previous[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
  }
  return costs.back();
}

/* Smallest edit distance, then first in the list; empty for an empty list. */
inline std::string nearestWord(const std::string& word, const std::vector<std::string>& words) {
  std::string nearest;
  size_t distance = ~size_t(0);
  for (const std::string& candidate : words) {
    const size_t d = editDistance(word, candidate);
    if (d < distance) {
      distance = d;
      nearest = candidate;
    }
  }
  return nearest;
}

} // namespace programs
