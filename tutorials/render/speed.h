// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Speed in turns with GRID, so that both see the same machine. */

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

  /* Throws Cancelled, as the next. */
  void measure(const BuiltScene& grid, const BuiltScene& scene, Result& result);

  /* GRID alone, when there is no other. */
  void measureGrid(const BuiltScene& grid);

  /* GRID's own speed, over all turns so far; none without any. */
  void noteGrid(Result& result) const;

private:
  void measureAll(const BuiltScene& grid, const BuiltScene* scene, Result* result);
  double time(const BuiltScene& scene, int set, int query) const;
  double mrays(int set, const std::vector<double>& seconds) const;

  const RaySets& sets;
  int repeat;
  std::vector<double> gridSeconds[numRaySets][numQueries];
};

} // namespace cbvh
