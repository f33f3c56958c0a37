// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A map in memory of one square tile per face, like a Ptex file. All faces must be quads. */

#include "surface/displacement.h"
#include "surface/height_map.h"

namespace programs {

/* A tile has tileSize + 1 texels per side; the outer ones lie on the face's borders. If tileSize is a power of two,
 * faces with equal texels on an edge meet exactly at levels up to 8. */
struct FaceAtlas {
  int tileSize = 64;
  int tilesPerRow = 1;

  static FaceAtlas forFaces(size_t numFaces, int tileSize);
  int columns() const { return tilesPerRow * (tileSize + 1); }
  int rows(size_t numFaces) const { return int((numFaces + tilesPerRow - 1) / tilesPerRow) * (tileSize + 1); }
};

/* Creates mip levels: a tent filter halves each tile, then border texels become the mean of all sides. Level L
 * reads, without filtering, the mip level whose texels are 2^-L of a face wide, up to 2^L = tileSize. */
std::unique_ptr<Displacement> displaceByAtlas(const Cage& cage, const FaceAtlas& atlas, HeightMap map, float scale);

} // namespace programs
