// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Edge rates that differ between edges. */

#include "surface/cage.h"
#include "surface/patch_point.h"

#include <cstddef>
#include <vector>

namespace programs {

struct EdgeRates {
  struct Copy {
    std::vector<float> rates;  // quads along the edge from a corner to the next, per face index
    std::vector<float> levels; // to which displacement is filtered at a corner, per face index
  };

  std::vector<Copy> copies;
  std::vector<size_t> firstIndex; // per face
  std::vector<unsigned> sizes;    // vertices per face
  size_t quads = 0;

  /* Level for filtering displacement at a point, interpolated between corners; the same on both sides of an edge. */
  float level(const Copy& copy, unsigned face, float u, float v) const;
};

/* Sets all members except for rates. The level of a vertex is the highest level of its edges. */
void setLevels(const Cage& cage, EdgeRates& rates);

/* Quads of a copy, including holes. `rates` holds one value per face index. */
size_t countQuads(const Cage& cage, const std::vector<float>& rates);

} // namespace programs
