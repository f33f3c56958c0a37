// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* UDIM: one file per unit square of texture coordinates, numbered 1001 + column + 10 row, with ten columns.
 *
 * In paths, <UDIM>, <udim> and %(UDIM)d stand for this number (1001), <UVTILE> and <U>_<V> for column and row from 1
 * (u1_v1), <uvtile> and <u>_<v> for column and row from 0 (u0_v0). */

#include "surface/cage.h"

#include <string>
#include <vector>

namespace programs {

/* False if there is a file with this very name, as in OpenImageIO. */
bool isUdimPath(const std::string& path);

/* Calls recordInputFile for each file that UdimTiles::find returns, and throws as it does. */
void recordMapFiles(const Cage& cage, const std::string& path);

struct UdimTiles {
  std::vector<std::string> paths; // existing files that faces use; the path itself without a placeholder

  /* Finds the files of the tiles at the middles of faces. Appends lines to `warnings` for tiles without a file,
   * faces that cross the border of their tile, and a cage laid out in tiles with a single file. Throws Error if no
   * tile has a file; a path without a placeholder is not checked. The cage must have texture coordinates. */
  static UdimTiles find(const Cage& cage, const std::string& path, std::string& warnings);

  bool isUdim() const { return !images.empty(); }

  /* Index into paths; -1 without a file. */
  int imageOf(unsigned face) const { return isUdim() ? images[face] : 0; }

  /* Origin of the face's tile, in texture coordinates. */
  Vec2f originOf(unsigned face) const { return isUdim() ? origins[face] : Vec2f{0, 0}; }

private:
  std::vector<int> images; // per face; empty without a placeholder
  std::vector<Vec2f> origins;
};

} // namespace programs
