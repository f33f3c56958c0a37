// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How finely the edges of a model are diced, where that is not one level for all. */

#include "surface/cage.h"
#include "surface/patch_point.h"

#include <cstddef>
#include <vector>

namespace cbvh {

struct EdgeRates
{
  /* Of a copy of the cage. */
  struct Copy
  {
    std::vector<float> rates;  // an index of the cage each, from that corner to the next: quads along the edge
    std::vector<float> levels; // likewise, of corners: the level to which displacement is filtered there
  };

  std::vector<Copy> copies;
  std::vector<size_t> firstIndex; // of faces
  std::vector<unsigned> sizes;    // likewise
  size_t quads = 0;               // of all

  /* The level at a point of a face: the same on both sides of an edge. */
  float level(const Copy& copy, unsigned face, float u, float v) const;
};

/* levels of a copy from its rates: at a vertex the highest of its edges has. */
void setLevels(const Cage& cage, EdgeRates& rates);

/* Quads of a copy. */
size_t countQuads(const Cage& cage, const std::vector<float>& rates);

} // namespace cbvh
