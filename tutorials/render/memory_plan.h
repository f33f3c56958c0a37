// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which representations fit into memory, decided before anything is built. */

#include "building/memory.h"

#include <cstddef>
#include <string>
#include <vector>

namespace cbvh {

struct MemoryPlan
{
  /* In the order in which they are built: GRID, which stays while the others come and go,
   * then NAIVE, then the compressed ones as they were asked for. */
  std::vector<Representation> built;
  std::vector<std::string> leftOut; // a line on each of the others
};

/* The compressed representations come first: GRID and NAIVE, with which they are compared,
 * are left out where they do not fit beside them.
 *
 * available: bytes.
 * Errors: throws Error when nothing fits. */
MemoryPlan planMemory(const std::vector<Representation>& asked, const BuildSize& size, size_t available);

} // namespace cbvh
