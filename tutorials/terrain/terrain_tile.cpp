// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "terrain_tile.h"
#include "basics/parallel.h"

#include <algorithm>
#include <cmath>

namespace programs {

TerrainTile makeTile(const Options& options, Elevation& elevation, const TerrainSpace& space, int x0, int y0) {
  TerrainTile tile;
  tile.width = std::min(options.tile, elevation.width() - 1 - x0) + 1;
  tile.height = std::min(options.tile, elevation.height() - 1 - y0) + 1;
  const std::vector<float> heights = elevation.heights(x0, y0, tile.width, tile.height, threadCount(options.threads));
  tile.vertices.resize(heights.size() + 1);
  for (size_t i = 0; i < heights.size(); i++) {
    const Vec3f vertex = space.vertex(x0 + int(i) % tile.width, y0 + int(i) / tile.width, heights[i]);
    tile.vertices[i] = vertex;
    if (std::isfinite(vertex.z)) tile.moved = std::max(tile.moved, std::abs(vertex.z - heights[i]));
  }
  return tile;
}

} // namespace programs
