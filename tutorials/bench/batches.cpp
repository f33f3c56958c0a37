// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "batches.h"
#include "building/memory.h"

#include <algorithm>
#include <cstdio>

namespace programs {

bool differOnlyByLibrary(const Variant& a, const Variant& b) {
  return a.representation.label() == b.representation.label() && a.isa == b.isa;
}

Batches planBatches(const std::vector<Representation>& representations, const std::vector<std::string>& isas,
                    const BuildSize& size, size_t available, const std::vector<bool>& compresses) {
  Batches plan;
  for (const std::string& isa : isas)
    for (size_t library = 0; library < compresses.size(); library++)
      plan.baselines.push_back({{RepresentationKind::Grid}, isa, library});
  const size_t base = baselineBytes(plan, size);
  plan.batches.emplace_back();
  size_t used = base;
  for (const Representation& r : representations)
    for (const std::string& isa : isas) {
      if (r.kind == RepresentationKind::Grid) continue;
      std::vector<Variant> perLibrary;
      for (size_t library = 0; library < compresses.size(); library++)
        (compresses[library] || !r.isCompressed() ? perLibrary : plan.unsupported).push_back({r, isa, library});
      const size_t bytes = perLibrary.size() * estimatedPeakBytes(r.kind, size);
      if (base + bytes > available) {
        plan.tooLarge.insert(plan.tooLarge.end(), perLibrary.begin(), perLibrary.end());
        continue;
      }
      if (used + bytes > available) {
        plan.batches.emplace_back();
        used = base;
      }
      plan.batches.back().insert(plan.batches.back().end(), perLibrary.begin(), perLibrary.end());
      used += bytes;
    }
  return plan;
}

size_t baselineBytes(const Batches& batches, const BuildSize& size) {
  return batches.baselines.size() * estimatedPeakBytes(RepresentationKind::Grid, size);
}

size_t neededBytes(const Batches& batches, const Variant& tooLarge, const BuildSize& size) {
  const auto perLibrary = std::count_if(batches.tooLarge.begin(), batches.tooLarge.end(),
                                        [&](const Variant& v) { return differOnlyByLibrary(v, tooLarge); });
  return baselineBytes(batches, size) + size_t(perLibrary) * estimatedPeakBytes(tooLarge.representation.kind, size);
}

std::string sizeMessage(const std::string& what, size_t quads, size_t needed, size_t available) {
  char text[200];
  std::snprintf(text, sizeof(text),
                "not enough memory: %s on %.1f million quads needs about %.1f GiB together with GRID, but %.1f GiB are "
                "free",
                what.c_str(), double(quads) * 1e-6, double(needed) / (1 << 30), double(available) / (1 << 30));
  return text;
}

} // namespace programs
