// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height maps computed from points of a generated scene's limit surface. Heights that depend only on the position
 * agree between faces. */

#include "surface/cage.h"
#include "surface/face_atlas.h"
#include "surface/height_map.h"

#include <functional>
#include <string>

namespace programs {

struct LimitPoint {
  unsigned face;
  float u, v;
  Vec3f position;
};

struct Bake {
  std::string name;
  unsigned threads;
  std::function<float(const LimitPoint&)> height; // must be thread-safe
};

/* One tile per face; border texels lie on the face's borders. Throws Error. */
HeightMap bakeTiles(const Cage& cage, const FaceAtlas& atlas, const Bake& bake);

/* Map of charts: `texels` x `texels` texels per face with centers inside the face, and a rim around each chart. Sets
 * the cage's texture coordinates. Throws Error. */
HeightMap bakeCharts(Cage& cage, int texels, const Bake& bake);

/* Sets only the texture coordinates, for a map that was baked earlier. */
void assignChartUVs(Cage& cage, int texels);

/* Displaces by baked tiles in memory, for cages of some hundred quads. `scale` is in world units per unit of height.
 * Throws Error. */
std::shared_ptr<const Displacement> displaceByBake(const Cage& cage, int tileSize, float scale, const Bake& bake);

std::string fingerprint(const Cage& cage);

} // namespace programs
