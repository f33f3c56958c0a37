// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "speed.h"

#include "basics/progress.h"
#include "measure/quantiles.h"

namespace cbvh {

/* GRID goes first in every other round. */
void SpeedInTurns::measure(const BuiltScene& scene, const BuiltScene* grid, Result& result)
{
  Phase phase(scene.representation().label() + ": speed");
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++)
    {
      std::vector<double> own, base;
      for (int i = 0; i < repeat; i++)
      {
        if (i % 2)
          own.push_back(time(scene, set, query));
        if (grid)
          base.push_back(time(*grid, set, query));
        if (i % 2 == 0)
          own.push_back(time(scene, set, query));
        phase.update(double((set * numQueries + query) * repeat + i + 1) / double(numRaySets * numQueries * repeat));
      }
      Speed& speed = result.speed[set][query];
      speed.mrays = mrays(set, own);
      if (grid)
        speed.toGrid = median(base) / median(own);
      gridSeconds[set][query].insert(gridSeconds[set][query].end(), base.begin(), base.end());
    }
}

void SpeedInTurns::noteGrid(Result& result) const
{
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++)
    {
      result.speed[set][query].toGrid = 1.0;
      if (!gridSeconds[set][query].empty())
        result.speed[set][query].mrays = mrays(set, gridSeconds[set][query]);
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
