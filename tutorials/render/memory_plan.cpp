// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "memory_plan.h"
#include "basics/error.h"
#include "building/memory.h"

#include <algorithm>
#include <cstdio>

namespace programs {
namespace {

class Planner {
public:
  Planner(const std::vector<Representation>& requested, const BuildSize& size, size_t available)
    : requested(requested),
      size(size),
      available(available) {}

  MemoryPlan plan() {
    const std::vector<Representation> compressed = fitting();
    size_t largest = 0, grid = 0;
    for (const Representation& r : compressed) largest = std::max(largest, peak(r.kind));
    const Representation* const gridRequest = find(RepresentationKind::Grid);
    if (gridRequest && fits(*gridRequest, largest, "next to the compressed ones")) {
      grid = peak(gridRequest->kind);
      result.built.push_back(*gridRequest);
    }
    for (RepresentationKind kind : {RepresentationKind::Naive, RepresentationKind::NaiveCompact}) {
      const Representation* const request = find(kind);
      if (request && fits(*request, grid, "next to GRID")) result.built.push_back(*request);
    }
    result.built.insert(result.built.end(), compressed.begin(), compressed.end());
    if (result.built.empty())
      throw Error("not enough memory: " + result.skipped.front() + "; expected a lower --level");
    return result;
  }

private:
  std::vector<Representation> fitting() {
    std::vector<Representation> compressed;
    for (const Representation& r : requested)
      if (r.isCompressed() && fits(r, 0, "")) compressed.push_back(r);
    return compressed;
  }

  const Representation* find(RepresentationKind kind) const {
    const auto found =
        std::find_if(requested.begin(), requested.end(), [&](const Representation& r) { return r.kind == kind; });
    return found == requested.end() ? nullptr : &*found;
  }

  size_t peak(RepresentationKind kind) const { return estimatedPeakBytes(kind, size); }

  /* Records the reason if `r` does not fit next to `other` bytes, which `user` describes. */
  bool fits(const Representation& r, size_t other, const std::string& user) {
    if (peak(r.kind) + other <= available) return true;
    constexpr double gib = double(1 << 30);
    char text[256];
    std::snprintf(text, sizeof(text),
                  "%s is left out: %.1f million quads need about %.1f GiB%s%s, but %.1f GiB are free",
                  r.label().c_str(), double(size.quads) * 1e-6, double(peak(r.kind) + other) / gib, other ? " " : "",
                  other ? user.c_str() : "", double(available) / gib);
    result.skipped.push_back(text);
    return false;
  }

  const std::vector<Representation>& requested;
  const BuildSize size;
  const size_t available;
  MemoryPlan result;
};

} // namespace

MemoryPlan planMemory(const std::vector<Representation>& requested, const BuildSize& size, size_t available) {
  return Planner(requested, size, available).plan();
}

} // namespace programs
