// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Texture coordinates for a closed cage of quads: each face becomes a square of the map, and adjacent faces form
 * charts. */

#include "surface/cage.h"

#include <vector>

namespace programs {

/* Place of a face in the map, in texels with y up: corner i of the face is corner (i + turn) mod 4 of the square,
 * counterclockwise from the lower left. */
struct ChartCell {
  int x = 0, y = 0, turn = 0;
};

struct Charts {
  int width = 0, height = 0; // of the map, in texels
  int texels = 0;            // per side of a face
  std::vector<ChartCell> cells;
  size_t count = 0; // of charts
};

/* `padding` is the width in texels of the space around each chart. */
Charts unfoldCharts(const Cage& cage, int texels, int padding);

void setChartUVs(Cage& cage, const Charts& charts);

} // namespace programs
