// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a part of the terrain, until it is committed. */

#include "elevation.h"
#include "options.h"
#include "basics/vec.h"

#include <vector>

namespace cbvh {

struct TerrainTile
{
  int width, height;           // in vertices
  std::vector<Vec3f> vertices; // by rows, plus one, because libraries may read 16 bytes per vertex
};

/* Vertex of the sample in column x and row y. The x axis points east, y north: row 0 is the northern edge. */
Vec3f vertexAt(const Options& options, const Elevation& elevation, int x, int y, float height);

/* Starts at column x0 and row y0. Neighboring tiles share the vertices between them. */
TerrainTile makeTile(const Options& options, Elevation& elevation, int x0, int y0);

} // namespace cbvh
