// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "batches.h"
#include "building/memory.h"

namespace cbvh {

Batches planBatches(const std::vector<Representation>& representations, const std::vector<std::string>& isas,
                    size_t quads, size_t available)
{
  Batches plan;
  for (const std::string& isa : isas)
    plan.baselines.push_back({{RepresentationKind::Grid}, isa});
  const size_t base = plan.baselines.size() * estimatedPeakBytes(RepresentationKind::Grid, quads);
  plan.rest.emplace_back();
  size_t used = base;
  for (const Representation& r : representations)
    for (const std::string& isa : isas)
    {
      if (r.kind == RepresentationKind::Grid)
        continue;
      const Variant variant{r, isa};
      const size_t bytes = estimatedPeakBytes(r.kind, quads);
      if (base + bytes > available)
      {
        plan.tooLarge.push_back(variant);
        continue;
      }
      if (used + bytes > available)
      {
        plan.rest.emplace_back();
        used = base;
      }
      plan.rest.back().push_back(variant);
      used += bytes;
    }
  return plan;
}

size_t neededBytes(const Batches& batches, const Variant& variant, size_t quads)
{
  return batches.baselines.size() * estimatedPeakBytes(RepresentationKind::Grid, quads) +
         estimatedPeakBytes(variant.representation.kind, quads);
}

} // namespace cbvh
