// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The unit in which a terrain is built: its vertices are in memory only until the tile is committed. */

#include "elevation.h"
#include "options.h"
#include "basics/vec.h"

#include <vector>

namespace cbvh {

struct TerrainTile
{
  int width, height;           // in vertices
  std::vector<Vec3f> vertices; // row by row, and one more, because libraries may read 16 bytes per vertex
};

/* The sample in column x and row y of the raster. The terrain's x points east and its y north: row 0 is the northern
 * edge. */
Vec3f vertexAt(const Options& options, const Elevation& elevation, int x, int y, float height);

/* The tile from column x0 and row y0 on. Neighboring tiles both contain the row or column of vertices between them. */
TerrainTile makeTile(const Options& options, Elevation& elevation, int x0, int y0);

} // namespace cbvh
