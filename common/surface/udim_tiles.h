// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* UDIM: a map in several files, one per unit square of texture coordinates. A tile has the number
 * 1001 + column + 10 row, with ten columns.
 *
 * In a path, <UDIM>, <udim> and %(UDIM)d stand for this number (1001), <UVTILE> and <U>_<V> for column and row counted
 * from 1 (u1_v1), <uvtile> and <u>_<v> for column and row counted from 0 (u0_v0). */

#include "surface/cage.h"

#include <string>
#include <vector>

namespace cbvh {

/* True if a path contains such a placeholder. */
bool isUdimPath(const std::string& path);

/* Records the files of a map as inputs of the run, see basics/input_files.h. */
void noteMapFiles(const Cage& cage, const std::string& path);

struct UdimTiles
{
  std::vector<std::string> paths; // files that exist and that faces use; the path itself if it has no placeholder

  /* Finds the files of the tiles at the middles of faces.
   * Appends lines to `warnings` for tiles without a file, for faces that cross the border of their tile, and for a cage
   * that is laid out in tiles while its map is one file. Throws Error if no file exists. */
  static UdimTiles find(const Cage& cage, const std::string& path, std::string& warnings);

  bool isUdim() const { return !images.empty(); }

  /* Index into paths; -1 if the face's tile has no file. */
  int imageOf(unsigned face) const { return isUdim() ? images[face] : 0; }

  /* Returns the origin of the face's tile, in texture coordinates. */
  Vec2f originOf(unsigned face) const { return isUdim() ? origins[face] : Vec2f{0, 0}; }

private:
  std::vector<int> images;    // per face; empty if the path has no placeholder
  std::vector<Vec2f> origins; // the same
};

} // namespace cbvh
