// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Speed, in turns with GRID where that is there, so that both see the same machine. */

#include "options.h"
#include "tracing/trace_timing.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace cbvh {

using RaySets = std::vector<Ray>[numRaySets];

/* As many as the options ask for. hits: of the primary rays. */
void makeRaySets(const Options& options, const TracedScene& scene, const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits, RaySets& sets);

struct Speed
{
  double mrays = 0;             // millions of rays a second, median
  std::optional<double> toGrid; // speed over that of GRID measured in turns with it, none without GRID
};
using Speeds = std::array<std::array<Speed, numQueries>, numRaySets>;

nlohmann::json speedJson(const Speeds& speeds);

class SpeedInTurns
{
public:
  /* The sets outlive this, and may be filled later. repeat: measurements, of which the
   * median counts. */
  SpeedInTurns(const RaySets& sets, int repeat) : sets(sets), repeat(repeat) {}

  /* grid: measured in turns with the scene, null for the scene alone. name: in the line of progress.
   * Throws Cancelled. */
  Speeds measure(const std::string& name, const TracedScene& scene, const TracedScene* grid);

  /* GRID's own speed, over all its turns so far; unchanged without any. */
  void noteGrid(Speeds& speeds) const;

private:
  double time(const TracedScene& scene, int set, int query) const;
  double mrays(int set, const std::vector<double>& seconds) const;

  const RaySets& sets;
  int repeat;
  std::vector<double> gridSeconds[numRaySets][numQueries];
};

} // namespace cbvh
