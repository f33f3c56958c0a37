// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "speed.h"

#include "basics/progress.h"
#include "measure/quantiles.h"

#include <nlohmann/json.hpp>

namespace cbvh {

void makeRaySets(const Options& options, const TracedScene& scene, const std::vector<Ray>& primary,
                 const std::vector<SurfaceHit>& hits, RaySets& sets)
{
  BounceSettings bounce;
  bounce.count = options.rays;
  bounce.offset = options.rayOffset * scene.bounds().diagonal();
  sets[Coherent] = coherentRays(primary, options.crop.size(), options.rays);
  sets[Incoherent] = bounceRays(primary, hits, bounce);
}

nlohmann::json speedJson(const Speeds& speeds)
{
  nlohmann::json j;
  for (RaySet set : {Coherent, Incoherent})
    for (Query query : {Closest, Any})
    {
      const Speed& speed = speeds[set][query];
      nlohmann::json& measured = j[raySetName(set)][queryName(query)];
      measured["mrays_per_second"] = speed.mrays;
      if (speed.toGrid)
        measured["relative_to_grid"] = *speed.toGrid;
    }
  return j;
}

/* Every other round measures GRID first. */
Speeds InterleavedSpeed::measure(const std::string& name, const TracedScene& scene, const TracedScene* grid)
{
  Phase phase(name + ": speed");
  Speeds speeds;
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
      Speed& speed = speeds[set][query];
      speed.mrays = mrays(set, own);
      if (grid)
        speed.toGrid = median(base) / median(own);
      gridSeconds[set][query].insert(gridSeconds[set][query].end(), base.begin(), base.end());
    }
  return speeds;
}

void InterleavedSpeed::setGridSpeed(Speeds& speeds) const
{
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++)
    {
      speeds[set][query].toGrid = 1.0;
      if (!gridSeconds[set][query].empty())
        speeds[set][query].mrays = mrays(set, gridSeconds[set][query]);
    }
}

double InterleavedSpeed::time(const TracedScene& scene, int set, int query) const
{
  TraceSettings settings;
  settings.query = Query(query);
  settings.coherent = set == Coherent;
  return timeTrace(scene, sets[set], settings).seconds;
}

double InterleavedSpeed::mrays(int set, const std::vector<double>& seconds) const
{
  return double(sets[set].size()) * 1e-6 / median(seconds);
}

} // namespace cbvh
