// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a part of the terrain, until it is committed. */

#include "elevation.h"
#include "options.h"
#include "terrain_space.h"
#include "basics/vec.h"

#include <vector>

namespace programs {

struct TerrainTile {
  int width, height;           // in vertices
  std::vector<Vec3f> vertices; // by rows, plus one, because libraries may read 16 bytes per vertex
  float moved = 0;             // largest distance of a stored height from the sample
};

/* Starts at column x0 and row y0. Neighboring tiles share the vertices between them. */
TerrainTile makeTile(const Options& options, Elevation& elevation, const TerrainSpace& space, int x0, int y0);

} // namespace programs
