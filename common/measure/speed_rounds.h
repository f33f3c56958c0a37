// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rounds in which a scene and GRID trace the same rays alternately, so that other load affects both. */

#include "measure/quantiles.h"

#include <cmath>
#include <vector>

namespace programs {

/* A ratio says nothing if its rounds differ by more than this fraction. */
constexpr double mostRoundDifference = 0.1;

/* Rounds are repeated until there are this many times as many as wanted, unless they agree earlier. */
constexpr int mostRepetitions = 4;

/* Interquartile range relative to the median. Requires at least one value. */
inline double spreadOf(const std::vector<double>& values) { return interquartileRange(values) / median(values); }

struct SpeedRounds {
  std::vector<double> own, grid; // seconds of each round; without GRID, `grid` is empty

  /* GRID's seconds as multiples of the scene's, per round. Requires GRID. */
  std::vector<double> ratios() const {
    std::vector<double> all;
    for (size_t i = 0; i < own.size(); i++) all.push_back(grid[i] / own[i]);
    return all;
  }

  /* How much the rounds differ, as a fraction of the median: in their ratio to GRID, or in their time without it. */
  double difference() const { return spreadOf(grid.empty() ? own : ratios()); }

  /* How much a ratio to GRID differs from these rounds: other load may have slowed GRID down next to this scene, or
   * next to another one. Requires GRID. */
  double differenceFrom(double ratio) const { return std::abs(ratio / median(ratios()) - 1.0); }
};

} // namespace programs
