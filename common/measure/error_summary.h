// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the errors of many hits come to, whatever they are measured against. */

#include <cstddef>
#include <optional>
#include <vector>

namespace cbvh {

struct ErrorSummary
{
  /* Distances in pixels at the hit. */
  double rmse = 0, median = 0, p99 = 0, max = 0;
  /* Degrees between geometric normals with their signs: 180 is a wrong sign. */
  double normalMedian = 0, normalP99 = 0;
  size_t flipped = 0; // normals that are more than 90 degrees off
  /* Distances in (u,v) in quads of the tessellation, over hits on the same patch as what
   * they are measured against; the others are counted. */
  double uvMedian = 0, uvP99 = 0;
  size_t otherPatch = 0;
};

/* The root of the mean of n squares; 0 when there are none. */
double rootOfMean(double sumOfSquares, size_t n);

class ErrorSamples
{
public:
  /* Of a hit. pixels: distance. degrees: between normals. quads: distance in (u,v), none
   * on another patch. */
  void add(float pixels, float degrees, std::optional<float> quads);

  size_t hits() const { return distances.size(); }

  /* Reorders the samples. */
  ErrorSummary summary();

private:
  std::vector<float> distances, angles, cells;
  double sumOfSquares = 0;
  size_t flipped = 0, otherPatch = 0;
};

} // namespace cbvh
