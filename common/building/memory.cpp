// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/memory.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

namespace cbvh {

size_t estimatedPeakBytes(RepresentationKind kind, const BuildSize& size)
{
  const size_t quads = size.quads, later = size.timeSteps - 1;
  switch (kind) // bytes per quad, for the first and for each later time step
  {
  case RepresentationKind::Naive: return quads * (265 + 30 * later); // measured without motion: 246
  case RepresentationKind::NaiveCompact: return quads * (205 + 30 * later); // measured: 194
  case RepresentationKind::Grid: return quads * (45 + 25 * later);
  case RepresentationKind::CGrid:
    if (later == 0)
      return quads * 25;
    [[fallthrough]]; // moving geometry is stored as cVERT
  default: return quads * (10 + 6 * later);
  }
}

size_t availableMemory()
{
  size_t available = SIZE_MAX;
  std::ifstream meminfo("/proc/meminfo");
  for (std::string key, rest; meminfo >> key && std::getline(meminfo, rest);)
    if (key == "MemAvailable:")
      available = std::min(available, size_t(std::strtoull(rest.c_str(), nullptr, 10)) * 1024);
  std::ifstream limitFile("/sys/fs/cgroup/memory.max"), usedFile("/sys/fs/cgroup/memory.current");
  size_t limit = 0, used = 0;
  if (limitFile >> limit && usedFile >> used) // fails for "max": no limit
    available = std::min(available, limit > used ? limit - used : 0);
  return available;
}

} // namespace cbvh
