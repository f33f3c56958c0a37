// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "terrain_space.h"

#include <algorithm>
#include <cmath>

namespace programs {
namespace {

/* Exponent of the power of two that is next to the cell, but not less than the spacing, so that x and y are multiples
 * of both. */
int stepExponent(float cell, float spacing) {
  const int exponent = int(std::lround(std::log2(double(cell))));
  return spacing > 0 ? std::max(exponent, std::ilogb(spacing)) : exponent;
}

} // namespace

TerrainSpace::TerrainSpace(const Options& options, int rows)
  : rows(rows),
    cell(double(options.cell)),
    startHeight(options.startHeight) {
  const bool isRounded = options.embree.empty() && options.maxError > 0;
  heightSpacing = isRounded ? std::ldexp(1.0f, std::ilogb(options.maxError)) : 0.0f;
  step = std::ldexp(1.0f, stepExponent(options.cell, heightSpacing));
}

float TerrainSpace::storedHeight(float height) const {
  if (!(heightSpacing > 0)) return height;
  const double spacing = double(heightSpacing);
  return float(std::nearbyint(double(height) / spacing) * spacing);
}

float TerrainSpace::rayHeight(float height) const {
  const float stored = storedHeight(height), next = std::nextafter(stored, INFINITY);
  return std::max(stored + startHeight, std::nextafter(next, INFINITY));
}

Vec3f TerrainSpace::direction(double azimuth, double elevation) const {
  const double factor = double(step) / cell, horizontal = std::cos(elevation) * factor;
  return {float(std::sin(azimuth) * horizontal), float(std::cos(azimuth) * horizontal), float(std::sin(elevation))};
}

} // namespace programs
