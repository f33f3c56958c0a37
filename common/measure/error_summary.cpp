// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/error_summary.h"
#include "measure/quantiles.h"

namespace programs {

double rootOfMean(double sumOfSquares, size_t n) { return n ? std::sqrt(sumOfSquares / double(n)) : 0.0; }

void ErrorSamples::add(float pixels, float degrees, std::optional<float> quads) {
  distances.push_back(pixels);
  sumOfSquares += double(pixels) * pixels;
  angles.push_back(degrees);
  flipped += degrees > 90.0f;
  if (quads) uvDistances.push_back(*quads);
  else otherPatch++;
}

ErrorSummary ErrorSamples::summary() {
  ErrorSummary s;
  s.rmse = rootOfMean(sumOfSquares, distances.size());
  s.median = quantile(distances, 0.5);
  s.p99 = quantile(distances, 0.99);
  s.max = quantile(distances, 1.0);
  s.normalMedian = quantile(angles, 0.5);
  s.normalP99 = quantile(angles, 0.99);
  s.flipped = flipped;
  s.uvMedian = quantile(uvDistances, 0.5);
  s.uvP99 = quantile(uvDistances, 0.99);
  s.otherPatch = otherPatch;
  return s;
}

} // namespace programs
