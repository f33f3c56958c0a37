// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/memory.h"

#include <cstddef>
#include <string>
#include <vector>

namespace programs {

struct MemoryPlan {
  /* In the order of building: GRID, which stays in memory, then NAIVE and NAIVE-compact, then the compressed ones. */
  std::vector<Representation> built;
  std::vector<std::string> skipped; // one line per representation that is left out
};

/* Leaves out compressed representations that do not fit alone, GRID if it does not fit next to the largest compressed
 * one, and NAIVE and NAIVE-compact if they do not fit next to GRID. `available` is in bytes. Throws Error if nothing
 * fits. */
MemoryPlan planMemory(const std::vector<Representation>& requested, const BuildSize& size, size_t available);

} // namespace programs
