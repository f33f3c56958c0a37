// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measures alternately with GRID, if it is built, and repeats rounds that differ. */

#include "options.h"
#include "measure/speed_rounds.h"
#include "tracing/trace_timing.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace programs {

using RaySets = std::vector<Ray>[numRaySets];

/* Number and offset of the rays are in the options. `hits` belong to the primary rays. */
void makeRaySets(const Options& options, const TracedScene& scene, const std::vector<Ray>& primary,
                 const std::vector<SurfaceHit>& hits, RaySets& sets);

struct Speed {
  double mrays = 0;             // median of millions of rays per second
  std::optional<double> toGrid; // quotient of `mrays` and GRID's; unset without GRID
  double difference = 0;        // of the rounds, as a fraction
  SpeedRounds rounds;

  /* True if toGrid says nothing. */
  bool isNoisy() const { return difference > mostRoundDifference; }
};
using Speeds = std::array<std::array<Speed, numQueries>, numRaySets>;

nlohmann::json speedJson(const Speeds& speeds);

class InterleavedSpeed {
public:
  /* Returns the seconds of tracing all rays once. */
  using Timer = std::function<double(const TracedScene&, const std::vector<Ray>&, const TraceSettings&)>;

  /* The sets must outlive this object and may be filled later. The median of `repeat` rounds is used, or of up to
   * mostRepetitions times as many if they differ. `timer` replaces timeTrace in tests. */
  InterleavedSpeed(const RaySets& sets, int repeat, Timer timer = nullptr);

  /* Alternates with `grid` unless it is null. `name` is for progress. Throws Canceled. */
  Speeds measure(const std::string& name, const TracedScene& scene, const TracedScene* grid);

  /* Relates speeds to GRID's median of all rounds. Call it after the last measure(), also for GRID's own speeds, which
   * it replaces by this median. Without rounds of GRID, only GRID's own are related. */
  void relateToGrid(Speeds& speeds, bool isGrid) const;

private:
  SpeedRounds alternate(const TracedScene& scene, const TracedScene* grid, int set, int query) const;
  double time(const TracedScene& scene, int set, int query) const;
  double mrays(int set, const std::vector<double>& seconds) const;

  const RaySets& sets;
  int repeat;
  Timer timer;
  std::vector<double> gridSeconds[numRaySets][numQueries];
};

} // namespace programs
