// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height maps computed from a function of points of a generated scene's limit surface. If the height depends on the
 * position alone, all faces at a common point agree. */

#include "surface/cage.h"
#include "surface/face_atlas.h"
#include "surface/height_map.h"

#include <functional>
#include <string>

namespace cbvh {

struct LimitPoint
{
  unsigned face;
  float u, v;
  Vec3f position;
};

/* Input of baking. */
struct Bake
{
  std::string name; // for progress
  unsigned threads;
  std::function<float(const LimitPoint&)> height; // must be thread-safe
};

/* Returns a map with one tile per face, whose border texels lie on the borders of the face. Throws Error. */
HeightMap bakeTiles(const Cage& cage, const FaceAtlas& atlas, const Bake& bake);

/* Returns a map of charts: `texels` x `texels` texels per face with their centers inside the face, and a rim around
 * each chart. Sets the cage's texture coordinates. Throws Error. */
HeightMap bakeCharts(Cage& cage, int texels, const Bake& bake);

/* Only sets the texture coordinates, for a map that was baked earlier. */
void unfoldForCharts(Cage& cage, int texels);

/* Bakes tiles in memory and displaces by them, for a cage of some hundred quads. `scale` is in world units per unit of
 * height. Throws Error. */
std::shared_ptr<const Displacement> displaceByBake(const Cage& cage, int tileSize, float scale, const Bake& bake);

/* Returns a hash of a cage as text. */
std::string fingerprint(const Cage& cage);

} // namespace cbvh
