// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Displacement: how far a point of the limit surface moves along its normal, a pure
 * function of face and (u,v), so every representation sees the very same surface.
 *
 * Texture coordinates are interpolated bilinearly over a face (over the corner
 * quads of an n-gon), not subdivided: on an edge they depend on the edge alone, so
 * the surface stays closed wherever both faces have the same coordinates there. On
 * a seam of the atlas they differ, both sides read their own height, and the
 * surface tears by the difference. */

#include "cage.h"
#include "height_map.h"

#include <cstddef>
#include <memory>

namespace cbvh {

class Displacement
{
public:
  virtual ~Displacement() = default;

  /* Offsets along the limit normal in world units.
   *
   * face: of the cage. n: number of points. u, v: n floats each, as Embree hands
   * them to displacement functions. offsets: n floats, written.
   * Thread safety: callable from any number of threads. */
  virtual void offsets(unsigned face, size_t n, const float* u, const float* v, float* offsets) const = 0;
};

/* scale * (height - neutral level) with the neutral level at 0.5. */
constexpr float neutralHeight = 0.5f;

/* Height map through the cage's own texture coordinates, which it must have. */
std::unique_ptr<Displacement> displaceByUVs(const Cage& cage, HeightMap map, float scale);

/* The whole map on every face, in the face's (u,v); every corner quad of an n-gon
 * gets a whole map too. Tears unless the border of the map is constant. */
std::unique_ptr<Displacement> displaceByFace(const Cage& cage, HeightMap map, float scale);

/* A map made of square tiles, one a face, in rows, each of tileSize + 1 texels a
 * side: the first and last texel of a tile lie on the borders of the face. With
 * tileSize a power of two, (u,v) of levels up to 8 fall on exact fractions of a
 * texel, and faces that agree on the texels of their common edge meet exactly.
 * All faces are quads. */
struct FaceAtlas
{
  int tileSize = 64;
  int tilesPerRow = 1;

  static FaceAtlas forFaces(size_t numFaces, int tileSize);
  int columns() const { return tilesPerRow * (tileSize + 1); }
  int rows(size_t numFaces) const { return int((numFaces + tilesPerRow - 1) / tilesPerRow) * (tileSize + 1); }
};
std::unique_ptr<Displacement> displaceByAtlas(const FaceAtlas& atlas, HeightMap map, float scale);

} // namespace cbvh
