// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The space in which the terrain is stored. The library rounds vertices to multiples of a power of two on all axes. A
 * cell of 0.2 is no multiple of one: x and y would move, and beside walls the stored surface would be above samples.
 * So x and y are counted in columns and rows times a power of two, and never move; the directions of rays have the
 * same factor. Heights keep the raster's unit, and are rounded before they are stored, so that rays can start above the
 * stored surface. */

#include "options.h"
#include "basics/vec.h"

namespace programs {

class TerrainSpace {
public:
  /* rows: of the raster. Heights are rounded unless options.embree is set. */
  TerrainSpace(const Options& options, int rows);

  /* Largest power of two that is at most options.maxError; 0 if heights are not rounded. */
  float spacing() const { return heightSpacing; }

  /* The nearest multiple of the spacing. Keeps NaN. */
  float storedHeight(float height) const;

  /* Vertex of the sample in column x and row y. The x axis points east, y north: row 0 is the northern edge. */
  Vec3f vertex(int x, int y, float height) const { return position(x, y, storedHeight(height)); }

  /* Height at which the sample's rays start: options.startHeight above the stored surface, or the second float above
   * it if floats are coarser. */
  float rayHeight(float height) const;
  Vec3f rayStart(int x, int y, float height) const { return position(x, y, rayHeight(height)); }

  /* Not of unit length. azimuth: from north to east. Both in radians. */
  Vec3f direction(double azimuth, double elevation) const;

private:
  Vec3f position(int x, int y, float z) const { return {step * float(x), step * float(rows - 1 - y), z}; }

  int rows;
  double cell;
  float step; // between stored columns and rows
  float heightSpacing;
  float startHeight;
};

} // namespace programs
