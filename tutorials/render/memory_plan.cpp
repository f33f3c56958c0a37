// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "memory_plan.h"
#include "basics/error.h"
#include "building/memory.h"

#include <algorithm>
#include <cstdio>

namespace cbvh {
namespace {

class Planner
{
public:
  Planner(const std::vector<Representation>& asked, const BuildSize& size, size_t available)
    : asked(asked), size(size), available(available)
  {
  }

  MemoryPlan plan()
  {
    const std::vector<Representation> compressed = fitting();
    size_t largest = 0, grid = 0;
    for (const Representation& r : compressed)
      largest = std::max(largest, peak(r.kind));
    if (const Representation* r = find(RepresentationKind::Grid); r && fits(*r, largest, "beside the compressed ones"))
    {
      grid = peak(r->kind);
      result.built.push_back(*r);
    }
    if (const Representation* r = find(RepresentationKind::Naive); r && fits(*r, grid, "beside GRID"))
      result.built.push_back(*r);
    result.built.insert(result.built.end(), compressed.begin(), compressed.end());
    if (result.built.empty())
      throw Error("not enough memory, lower --level: " + result.leftOut.front());
    return result;
  }

private:
  std::vector<Representation> fitting()
  {
    std::vector<Representation> compressed;
    for (const Representation& r : asked)
      if (r.isCompressed() && fits(r, 0, ""))
        compressed.push_back(r);
    return compressed;
  }

  const Representation* find(RepresentationKind kind) const
  {
    const auto found = std::find_if(asked.begin(), asked.end(), [&](const Representation& r) { return r.kind == kind; });
    return found == asked.end() ? nullptr : &*found;
  }

  size_t peak(RepresentationKind kind) const { return estimatedPeakBytes(kind, size); }

  /* Notes what does not fit. other: bytes that are in use meanwhile, by what `beside` says. */
  bool fits(const Representation& r, size_t other, const std::string& beside)
  {
    if (peak(r.kind) + other <= available)
      return true;
    constexpr double gib = double(1 << 30);
    char text[256];
    std::snprintf(text, sizeof(text), "%s is left out: %.1f million quads take about %.1f GiB%s%s, and %.1f are free",
                  r.label().c_str(), double(size.quads) * 1e-6, double(peak(r.kind) + other) / gib, other ? " " : "",
                  other ? beside.c_str() : "", double(available) / gib);
    result.leftOut.push_back(text);
    return false;
  }

  const std::vector<Representation>& asked;
  const BuildSize size;
  const size_t available;
  MemoryPlan result;
};

} // namespace

MemoryPlan planMemory(const std::vector<Representation>& asked, const BuildSize& size, size_t available)
{
  return Planner(asked, size, available).plan();
}

} // namespace cbvh
