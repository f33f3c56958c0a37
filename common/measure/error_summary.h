// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Statistics of the errors of many hits, for any reference. */

#include <cstddef>
#include <optional>
#include <vector>

namespace cbvh {

struct ErrorSummary
{
  /* Distances in pixels at the hit. */
  double rmse = 0, median = 0, p99 = 0, max = 0;
  /* Degrees between geometric normals. Signs count: 180 is a wrong sign. */
  double normalMedian = 0, normalP99 = 0;
  size_t flipped = 0; // normals that are more than 90 degrees off
  /* Distances in (u,v), in quads of the tessellation, over hits on the same patch as the reference. Other hits are
   * counted in otherPatch. */
  double uvMedian = 0, uvP99 = 0;
  size_t otherPatch = 0;
};

/* Returns the square root of the mean of n squares, or 0 if n is 0. */
double rootOfMean(double sumOfSquares, size_t n);

class ErrorSamples
{
public:
  /* Adds a hit: its distance in pixels, the angle between normals in degrees, and the distance in (u,v) in quads, or
   * nothing on another patch. */
  void add(float pixels, float degrees, std::optional<float> quads);

  size_t hits() const { return distances.size(); }

  /* Returns the statistics. Reorders the samples. */
  ErrorSummary summary();

private:
  std::vector<float> distances, angles, cells;
  double sumOfSquares = 0;
  size_t flipped = 0, otherPatch = 0;
};

} // namespace cbvh
