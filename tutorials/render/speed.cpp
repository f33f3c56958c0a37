// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "speed.h"

#include "basics/progress.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace programs {

void makeRaySets(const Options& options, const TracedScene& scene, const std::vector<Ray>& primary,
                 const std::vector<SurfaceHit>& hits, RaySets& sets) {
  BounceSettings bounce;
  bounce.count = options.rays;
  bounce.offset = options.rayOffset * scene.bounds().diagonal();
  sets[Coherent] = coherentRays(primary, options.crop.size(), options.rays);
  sets[Incoherent] = bounceRays(primary, hits, bounce);
}

nlohmann::json speedJson(const Speeds& speeds) {
  nlohmann::json j;
  for (RaySet set : {Coherent, Incoherent})
    for (Query query : {Closest, Any}) {
      const Speed& speed = speeds[set][query];
      nlohmann::json& measured = j[raySetName(set)][queryName(query)];
      measured["mrays_per_second"] = speed.mrays;
      measured["rounds"] = speed.rounds.own.size();
      measured["rounds_differ_by"] = speed.difference;
      if (speed.toGrid) measured["relative_to_grid"] = *speed.toGrid;
    }
  return j;
}

InterleavedSpeed::InterleavedSpeed(const RaySets& sets, int repeat, Timer timer)
  : sets(sets),
    repeat(repeat),
    timer(std::move(timer)) {
  if (!this->timer)
    this->timer = [](const TracedScene& scene, const std::vector<Ray>& rays, const TraceSettings& settings) {
      return timeTrace(scene, rays, settings).seconds;
    };
}

/* Every other round measures GRID first. */
SpeedRounds InterleavedSpeed::alternate(const TracedScene& scene, const TracedScene* grid, int set, int query) const {
  SpeedRounds rounds;
  do
    for (int i = 0; i < repeat; i++) {
      if (i % 2) rounds.own.push_back(time(scene, set, query));
      if (grid) rounds.grid.push_back(time(*grid, set, query));
      if (i % 2 == 0) rounds.own.push_back(time(scene, set, query));
    }
  while (rounds.difference() > mostRoundDifference && rounds.own.size() < size_t(mostRepetitions) * size_t(repeat));
  return rounds;
}

Speeds InterleavedSpeed::measure(const std::string& name, const TracedScene& scene, const TracedScene* grid) {
  Phase phase(name + ": speed");
  Speeds speeds;
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++) {
      Speed& speed = speeds[set][query];
      speed.rounds = alternate(scene, grid, set, query);
      speed.mrays = mrays(set, speed.rounds.own);
      speed.difference = speed.rounds.difference();
      std::vector<double>& all = gridSeconds[set][query];
      all.insert(all.end(), speed.rounds.grid.begin(), speed.rounds.grid.end());
      phase.update(double(set * numQueries + query + 1) / double(numRaySets * numQueries));
    }
  return speeds;
}

void InterleavedSpeed::relateToGrid(Speeds& speeds, bool isGrid) const {
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++) {
      Speed& speed = speeds[set][query];
      const std::vector<double>& all = gridSeconds[set][query];
      if (isGrid && !all.empty()) {
        speed.rounds.own = all;
        speed.mrays = mrays(set, all);
        speed.difference = spreadOf(all);
      }
      if (isGrid) speed.toGrid = 1.0;
      else if (!all.empty()) {
        speed.toGrid = speed.mrays / mrays(set, all);
        speed.difference = std::max(speed.difference, speed.rounds.differenceFrom(*speed.toGrid));
      }
    }
}

double InterleavedSpeed::time(const TracedScene& scene, int set, int query) const {
  TraceSettings settings;
  settings.query = Query(query);
  settings.coherent = set == Coherent;
  return timer(scene, sets[set], settings);
}

double InterleavedSpeed::mrays(int set, const std::vector<double>& seconds) const {
  return double(sets[set].size()) * 1e-6 / median(seconds);
}

} // namespace programs
