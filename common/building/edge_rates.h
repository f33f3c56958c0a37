// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Edge rates of a model whose edges do not all have the same level. */

#include "surface/cage.h"
#include "surface/patch_point.h"

#include <cstddef>
#include <vector>

namespace cbvh {

struct EdgeRates
{
  /* Rates of one copy of the cage. */
  struct Copy
  {
    std::vector<float> rates;  // quads along the edge from a corner to the next, per face index of the cage
    std::vector<float> levels; // level to which displacement is filtered at a corner, per face index
  };

  std::vector<Copy> copies;
  std::vector<size_t> firstIndex; // per face
  std::vector<unsigned> sizes;    // per face
  size_t quads = 0;               // of all copies

  /* Returns the level at a point of a face. It is the same on both sides of an edge. */
  float level(const Copy& copy, unsigned face, float u, float v) const;
};

/* Sets the levels from the rates: a vertex gets the highest level of its edges. Also sets everything else but rates. */
void setLevels(const Cage& cage, EdgeRates& rates);

/* Returns the number of quads of a copy. */
size_t countQuads(const Cage& cage, const std::vector<float>& rates);

} // namespace cbvh
