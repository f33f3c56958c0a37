// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "batches.h"
#include "building/memory.h"

#include <cstdio>

namespace cbvh {

Batches planBatches(const std::vector<Representation>& representations, const std::vector<std::string>& isas,
                    size_t quads, size_t available)
{
  Batches plan;
  for (const std::string& isa : isas)
    plan.baselines.push_back({{RepresentationKind::Grid}, isa});
  const size_t base = baselineBytes(plan, quads);
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

size_t baselineBytes(const Batches& batches, size_t quads)
{
  return batches.baselines.size() * estimatedPeakBytes(RepresentationKind::Grid, quads);
}

size_t neededBytes(const Batches& batches, const Variant& variant, size_t quads)
{
  return baselineBytes(batches, quads) + estimatedPeakBytes(variant.representation.kind, quads);
}

std::string sizeMessage(const std::string& what, size_t quads, size_t needed, size_t available)
{
  char text[200];
  std::snprintf(text, sizeof(text),
                "not enough memory: %s on %.1f million quads takes about %.1f GiB with GRID, and %.1f are free",
                what.c_str(), double(quads) * 1e-6, double(needed) / (1 << 30), double(available) / (1 << 30));
  return text;
}

} // namespace cbvh
