// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A part of the terrain, whose vertices are in memory only until it is committed. */

#include "elevation.h"
#include "options.h"
#include "basics/vec.h"

#include <vector>

namespace cbvh {

struct TerrainTile
{
  int width, height;           // in vertices
  std::vector<Vec3f> vertices; // row by row, plus one, because libraries may read 16 bytes per vertex
};

/* Returns the vertex of the sample in column x and row y of the raster. The terrain's x axis points east and its y axis
 * north: row 0 is the northern edge. */
Vec3f vertexAt(const Options& options, const Elevation& elevation, int x, int y, float height);

/* Returns the tile from column x0 and row y0 on. Neighboring tiles share the row or column of vertices between them. */
TerrainTile makeTile(const Options& options, Elevation& elevation, int x0, int y0);

} // namespace cbvh
