// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* UDIM: a map of several files, one a unit square of texture coordinates. Tile
 * 1001 + column + 10 row, ten columns.
 *
 * A path names the tile by <UDIM>, <udim> or %(UDIM)d (1001), <UVTILE> or <U>_<V> (u1_v1),
 * or <uvtile> or <u>_<v>, which count from 0 (u0_v0). */

#include "surface/cage.h"

#include <string>
#include <vector>

namespace cbvh {

/* True if a path names tiles in one of these ways. */
bool isUdimPath(const std::string& path);

/* Notes the files of a map as inputs of the run, see basics/input_files.h. */
void noteMapFiles(const Cage& cage, const std::string& path);

struct UdimTiles
{
  std::vector<std::string> paths; // of the files that there are and faces lie on; the path itself if it names no tiles

  /* Looks for the tiles on which faces have their middles.
   * warnings: lines are added on tiles without a file, on faces that reach over the border
   * of their tile, and where a cage that is laid out in tiles reads one map on all of them.
   * Errors: throws Error when there is no file at all. */
  static UdimTiles find(const Cage& cage, const std::string& path, std::string& warnings);

  bool isUdim() const { return !images.empty(); }

  /* Index into paths; -1 where there is no file. */
  int imageOf(unsigned face) const { return isUdim() ? images[face] : 0; }

  /* Of the face's tile, in texture coordinates. */
  Vec2f originOf(unsigned face) const { return isUdim() ? origins[face] : Vec2f{0, 0}; }

private:
  std::vector<int> images;    // a face each, empty if the path names no tiles
  std::vector<Vec2f> origins; // likewise
};

} // namespace cbvh
