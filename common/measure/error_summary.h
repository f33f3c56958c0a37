// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace programs {

struct ErrorSummary {
  /* Distances, in pixels at the hit. */
  double rmse = 0, median = 0, p99 = 0, max = 0;
  /* Angles between geometric normals in degrees; 180 is a wrong sign. */
  double normalMedian = 0, normalP99 = 0;
  size_t flipped = 0; // normals with an error above 90 degrees
  /* Distances in (u,v), in quads, of hits on the same patch as the reference. otherPatch counts the other hits. */
  double uvMedian = 0, uvP99 = 0;
  size_t otherPatch = 0;
};

/* Returns 0 if n is 0. */
double rootOfMean(double sumOfSquares, size_t n);

class ErrorSamples {
public:
  /* Adds a hit: distance in pixels, angle between normals in degrees, and distance in (u,v) in quads, or none on
   * another patch. */
  void add(float pixels, float degrees, std::optional<float> quads);

  size_t hits() const { return distances.size(); }

  /* Reorders the samples. */
  ErrorSummary summary();

private:
  std::vector<float> distances, angles, uvDistances;
  double sumOfSquares = 0;
  size_t flipped = 0, otherPatch = 0;
};

} // namespace programs
