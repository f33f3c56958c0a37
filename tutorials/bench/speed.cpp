// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "speed.h"

#include "basics/progress.h"

#include <algorithm>
#include <cmath>

namespace programs {
namespace {

struct Combination {
  const View* view;
  RaySet set;
  TraceSettings trace;

  const std::vector<Ray>& rays() const { return view->sets[set]; }
};

std::vector<Combination> combine(const BenchOptions& options, const std::vector<View>& views) {
  std::vector<Combination> combinations;
  for (const View& view : views)
    for (RaySet set : options.sets)
      for (Query query : options.queries)
        for (TraceMode mode : options.modes)
          for (unsigned n : options.threads)
            if (!view.sets[set].empty()) combinations.push_back({&view, set, {query, mode, set == Coherent, n, 1}});
  return combinations;
}

/* Passes, at most 100, for which GRID takes 20 ms, so that clocks and waking threads do not matter. */
unsigned passesFor(double gridSeconds) {
  constexpr double sampleSeconds = 0.02, most = 100.0;
  constexpr double shortest = 1e-6; // a clock may return 0
  return unsigned(std::min(most, std::ceil(sampleSeconds / std::max(gridSeconds, shortest))));
}

/* Each round begins with another variant, and every other round runs backwards. The warm-up round is -1. */
size_t indexInRound(size_t k, int round, size_t n) {
  const size_t turn = (k + size_t(round + 1)) % n;
  return round % 2 ? n - 1 - turn : turn;
}

size_t gridOf(const std::vector<BuiltVariant>& batch, const Variant& variant) {
  size_t grid = 0;
  while (batch[grid].variant().isa != variant.isa || batch[grid].variant().library != variant.library) grid++;
  return grid;
}

Speed recordOf(const Combination& combination) {
  Speed speed;
  speed.view = combination.view->name;
  speed.set = combination.set;
  speed.trace = combination.trace;
  speed.rays = combination.rays().size();
  return speed;
}

/* Records one round of a combination at `index` of every result. GRID's record grows with every batch. */
void record(const std::vector<BuiltVariant>& batch, size_t index, const Combination& combination,
            const std::vector<TraceTiming>& timings) {
  for (size_t i = 0; i < batch.size(); i++) {
    VariantResult& result = batch[i].result();
    if (result.speeds.size() <= index) result.speeds.push_back(recordOf(combination));
    const double gridSeconds = timings[gridOf(batch, result.variant)].seconds;
    Speed& speed = result.speeds[index];
    speed.hits = timings[i].hits;
    speed.seconds.push_back(timings[i].seconds);
    speed.toGrid.push_back(gridSeconds / timings[i].seconds);
    if (const std::optional<size_t> first = findInFirstLibrary(batch, i))
      speed.toFirst.push_back(timings[*first].seconds / timings[i].seconds);
  }
}

} // namespace

void measureSpeed(const BenchOptions& options, const std::vector<View>& views, const std::vector<BuiltVariant>& batch,
                  const std::string& title) {
  std::vector<Combination> combinations = combine(options, views);
  Phase phase(title);
  const size_t samples = combinations.size() * batch.size() * (size_t(options.repeat) + 1);
  size_t measured = 0;
  for (int round = -1; round < options.repeat; round++) // the first one warms up and sets the passes
    for (size_t c = 0; c < combinations.size(); c++) {
      Combination& combination = combinations[c];
      std::vector<TraceTiming> timings(batch.size());
      for (size_t k = 0; k < batch.size(); k++) {
        const size_t i = indexInRound(k, round, batch.size());
        timings[i] = timeTrace(batch[i].use(), combination.rays(), combination.trace);
        phase.update(double(++measured) / double(samples));
      }
      if (round < 0) combination.trace.passes = passesFor(timings[0].seconds);
      else record(batch, c, combination, timings);
    }
}

} // namespace programs
