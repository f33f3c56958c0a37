// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Summaries of repeated measurements. */

#include <algorithm>
#include <vector>

namespace cbvh {

/* Of at least one value. */
inline double median(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/* Range of the middle half of the values, at least one, by nearest ranks. */
inline double interquartileRange(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  const size_t quarter = values.size() / 4;
  return values[values.size() - 1 - quarter] - values[quarter];
}

} // namespace cbvh
