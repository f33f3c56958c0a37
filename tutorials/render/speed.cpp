// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "speed.h"

#include "basics/progress.h"
#include "measure/quantiles.h"

namespace cbvh {

void SpeedInTurns::measure(const BuiltScene& grid, const BuiltScene& scene, Result& result)
{
  measureAll(grid, &scene, &result);
}

void SpeedInTurns::measureGrid(const BuiltScene& grid)
{
  measureAll(grid, nullptr, nullptr);
}

void SpeedInTurns::noteGrid(Result& result) const
{
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++)
      if (!gridSeconds[set][query].empty())
        result.speed[set][query].mrays = mrays(set, gridSeconds[set][query]);
}

/* GRID goes first in every other round. scene: null for GRID alone. */
void SpeedInTurns::measureAll(const BuiltScene& grid, const BuiltScene* scene, Result* result)
{
  Phase phase((scene ? *scene : grid).representation().label() + ": speed");
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++)
    {
      std::vector<double> own, base;
      for (int i = 0; i < repeat; i++)
      {
        if (scene && i % 2)
          own.push_back(time(*scene, set, query));
        base.push_back(time(grid, set, query));
        if (scene && i % 2 == 0)
          own.push_back(time(*scene, set, query));
        phase.update(double((set * numQueries + query) * repeat + i + 1) / double(numRaySets * numQueries * repeat));
      }
      gridSeconds[set][query].insert(gridSeconds[set][query].end(), base.begin(), base.end());
      if (scene)
        result->speed[set][query] = {mrays(set, own), median(base) / median(own)};
    }
}

double SpeedInTurns::time(const BuiltScene& scene, int set, int query) const
{
  TraceSettings settings;
  settings.query = Query(query);
  settings.coherent = set == Coherent;
  return timeTrace(scene, sets[set], settings).seconds;
}

double SpeedInTurns::mrays(int set, const std::vector<double>& seconds) const
{
  return double(sets[set].size()) * 1e-6 / median(seconds);
}

} // namespace cbvh
