// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "hit_agreement.h"

#include "basics/parallel.h"

namespace programs {
namespace {

HitAgreement agreementOf(const BuiltVariant& first, const BuiltVariant& other, const View& view, RaySet set,
                         const TraceSettings& trace) {
  const std::vector<HitRecord> hits = recordHits(first.use(), view.sets[set], trace);
  return {view.name, set, trace, compareHitRecords(hits, recordHits(other.use(), view.sets[set], trace))};
}

} // namespace

void compareLibraries(const BenchOptions& options, const std::vector<View>& views,
                      const std::vector<BuiltVariant>& batch, const std::string& title) {
  const unsigned threads = threadCount(options.buildThreads);
  Phase phase(title);
  for (size_t i = 0; i < batch.size(); i++) {
    phase.update(double(i) / double(batch.size()));
    const std::optional<size_t> first = findInFirstLibrary(batch, i);
    std::vector<HitAgreement>& agreements = batch[i].result().agreements;
    if (!first || !agreements.empty()) // baselines are in every batch
      continue;
    for (const View& view : views)
      for (RaySet set : options.sets)
        for (Query query : options.queries)
          for (TraceMode mode : options.modes) {
            const TraceSettings trace{query, mode, set == Coherent, threads};
            agreements.push_back(agreementOf(batch[*first], batch[i], view, set, trace));
          }
  }
}

} // namespace programs
