// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Height maps computed from what a generated scene says about points of its limit
 * surface. A height that depends on the position alone is the same from all faces
 * that meet there. */

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

/* What is baked, and how. */
struct Bake
{
  std::string name; // as progress shows it
  unsigned threads;
  std::function<float(const LimitPoint&)> height; // called from several threads
};

/* A tile a face, whose border texels lie on the borders of the face. Throws Error,
 * Cancelled. */
HeightMap bakeTiles(const Cage& cage, const FaceAtlas& atlas, const Bake& bake);

/* Texels of charts: `texels` squared of them a face, their centres inside it, and a
 * rim around each chart. Fills the cage's texture coordinates. Throws as bakeTiles. */
HeightMap bakeCharts(Cage& cage, int texels, const Bake& bake);

/* Texture coordinates alone, for a map that is there already. */
void unfoldForCharts(Cage& cage, int texels);

/* Bakes tiles in memory for a cage of some hundred quads and displaces by them.
 * scale: world units from height 0 to 1. */
std::shared_ptr<const Displacement> displaceByBake(const Cage& cage, int tileSize, float scale, const Bake& bake);

/* A number that differs between cages. */
std::string fingerprint(const Cage& cage);

} // namespace cbvh
