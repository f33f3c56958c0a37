// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Texture coordinates for a closed cage of quads: unfolded face by face onto a square
 * lattice, so that every face is a square of its own size in the map, in charts as
 * large as they stay compact. */

#include "surface/cage.h"

#include <vector>

namespace cbvh {

/* Where a face lies in the map: corner i of the face is corner (i + turn) mod 4 of
 * the square, counterclockwise from the lower left. In texels, y up. */
struct ChartCell
{
  int x = 0, y = 0, turn = 0;
};

struct Charts
{
  int width = 0, height = 0;     // of the map, in texels
  int texels = 0;                // a side of a face
  std::vector<ChartCell> cells;  // a face each
  size_t count = 0;              // of charts
};

/* rim: texels between a chart and the border of its place, on each side. */
Charts unfoldCharts(const Cage& cage, int texels, int rim);

/* Writes the texture coordinates of charts into a cage. */
void setChartUVs(Cage& cage, const Charts& charts);

} // namespace cbvh
