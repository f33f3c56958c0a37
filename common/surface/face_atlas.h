// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A map made of square tiles, one a face, in rows, in memory: Ptex in one picture.
 * All faces are quads. */

#include "surface/displacement.h"
#include "surface/height_map.h"

namespace cbvh {

/* A tile has tileSize + 1 texels a side: the first and last lie on the borders of the
 * face. With tileSize a power of two, (u,v) of levels up to 8 fall on exact fractions
 * of a texel, and faces that agree on the texels of their common edge meet exactly. */
struct FaceAtlas
{
  int tileSize = 64;
  int tilesPerRow = 1;

  static FaceAtlas forFaces(size_t numFaces, int tileSize);
  int columns() const { return tilesPerRow * (tileSize + 1); }
  int rows(size_t numFaces) const { return int((numFaces + tilesPerRow - 1) / tilesPerRow) * (tileSize + 1); }
};

/* Mip levels are made here: halved a tile by itself by a tent filter, then the mean of
 * all sides on the borders. A tile's level k is read at levels L with 2^-L as wide as
 * its texels: exactly at them, without any filter, up to 2^L = tileSize. */
std::unique_ptr<Displacement> displaceByAtlas(const Cage& cage, const FaceAtlas& atlas, HeightMap map, float scale);

} // namespace cbvh
