// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Speed, in turns with GRID where that is there, so that both see the same machine. */

#include "comparison.h"
#include "building/built_scene.h"

#include <vector>

namespace cbvh {

using RaySets = std::vector<Ray>[numRaySets];

class SpeedInTurns
{
public:
  /* The sets outlive this, and may be filled later. repeat: measurements, of which the
   * median counts. */
  SpeedInTurns(const RaySets& sets, int repeat) : sets(sets), repeat(repeat) {}

  /* grid: measured in turns with the scene, null for the scene alone. Throws Cancelled. */
  void measure(const BuiltScene& scene, const BuiltScene* grid, Result& result);

  /* GRID's own speed, over all its turns so far; unchanged without any. */
  void noteGrid(Result& result) const;

private:
  double time(const BuiltScene& scene, int set, int query) const;
  double mrays(int set, const std::vector<double>& seconds) const;

  const RaySets& sets;
  int repeat;
  std::vector<double> gridSeconds[numRaySets][numQueries];
};

} // namespace cbvh
