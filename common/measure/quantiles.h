// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace programs {

/* Nearest rank. Reorders the values. Returns 0 if there are none. */
inline double quantile(std::vector<float>& values, double q) {
  if (values.empty()) return 0.0;
  const double rank = std::ceil(q * double(values.size()));
  const size_t k = size_t(std::min(std::max(rank - 1.0, 0.0), double(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + ptrdiff_t(k), values.end());
  return values[k];
}

/* Requires at least one value. */
inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/* Requires at least one value. */
inline double interquartileRange(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t quarter = values.size() / 4;
  return values[values.size() - 1 - quarter] - values[quarter];
}

} // namespace programs
