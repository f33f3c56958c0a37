// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measures alternately with GRID, if it is built, so that other load affects both. */

#include "options.h"
#include "tracing/trace_timing.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace cbvh {

using RaySets = std::vector<Ray>[numRaySets];

/* Number and offset of the rays are in the options. `hits` belong to the primary rays. */
void makeRaySets(const Options& options, const TracedScene& scene, const std::vector<Ray>& primary,
                 const std::vector<SurfaceHit>& hits, RaySets& sets);

struct Speed
{
  double mrays = 0;             // median of millions of rays per second
  std::optional<double> toGrid; // relative to GRID; unset without it
};
using Speeds = std::array<std::array<Speed, numQueries>, numRaySets>;

nlohmann::json speedJson(const Speeds& speeds);

class InterleavedSpeed
{
public:
  /* The sets must outlive this object and may be filled later. The median of `repeat` measurements is used. */
  InterleavedSpeed(const RaySets& sets, int repeat) : sets(sets), repeat(repeat) {}

  /* Alternates with `grid` unless it is null. `name` is for progress. Throws Canceled. */
  Speeds measure(const std::string& name, const TracedScene& scene, const TracedScene* grid);

  /* Sets GRID's speed from all its measurements so far, if any. */
  void setGridSpeed(Speeds& speeds) const;

private:
  double time(const TracedScene& scene, int set, int query) const;
  double mrays(int set, const std::vector<double>& seconds) const;

  const RaySets& sets;
  int repeat;
  std::vector<double> gridSeconds[numRaySets][numQueries];
};

} // namespace cbvh
