// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Charts of texture coordinates. A chart consists of faces that share edges on which their coordinates are the same,
 * and is not mirrored across an edge. All other shared edges are seams.
 *
 * A chart ends at its seams, with two exceptions. If the map repeats and the coordinates of both sides differ by whole
 * numbers, the map continues across the seam. At the boundary of a cage the map continues, too: another cage may be
 * displaced by the next part of the map, and both must have the same heights there. */

#include "surface/cage.h"
#include "surface/face_borders.h"
#include "surface/udim_tiles.h"

#include <algorithm>
#include <vector>

namespace programs {

class TextureCharts {
public:
  /* `uvs`: one per corner of a face. */
  TextureCharts(const Cage& cage, const FaceBorders& faces, const std::vector<Vec2f>& uvs, const UdimTiles& tiles,
                bool repeats);

  unsigned chartOf(unsigned face) const { return charts[face]; }

  /* True if the sides of the edge from a corner to the next differ, or the faces around the corner. Corners are
   * numbered as in FaceBorders. */
  bool edgeDiffers(size_t corner) const { return differingEdges[corner]; }
  bool cornerDiffers(size_t corner) const { return differingCorners[corner]; }

  /* Where a chart ends, in coordinates of its image: (0,0) is the upper left corner, (1,1) the lower right. For points
   * q of the chart beside it, cross(b - a, q - a) is positive. */
  struct End {
    Vec2f a, b;
  };

  /* Calls `function(End)` for all ends of a chart that may touch the box, some of them more than once. */
  template<typename Function>
  void forEndsNear(unsigned chart, Vec2f lower, Vec2f upper, const Function& function) const {
    const Grid& grid = grids[chart];
    if (grid.columns == 0 ||
        !(lower.x <= grid.upper.x && lower.y <= grid.upper.y && upper.x >= grid.lower.x && upper.y >= grid.lower.y))
      return;
    for (int row = grid.row(lower.y); row <= grid.row(upper.y); row++) {
      const size_t first = grid.firstCell + size_t(row) * size_t(grid.columns);
      for (size_t i = firstEnd[first + size_t(grid.column(lower.x))];
           i < firstEnd[first + size_t(grid.column(upper.x)) + 1]; i++)
        function(ends[i]);
    }
  }

private:
  /* A chart's ends by position. */
  struct Grid {
    Vec2f lower, upper;
    int columns = 0, rows = 0; // 0 if the chart does not end
    size_t firstCell = 0;

    int column(float x) const { return cell(x, lower.x, upper.x, columns); }
    int row(float y) const { return cell(y, lower.y, upper.y, rows); }

    static int cell(float x, float lower, float upper, int n) {
      const float at = (x - lower) / (upper - lower) * float(n);
      return at > 0.0f ? int(std::min(at, float(n - 1))) : 0; // also 0 if not a number
    }
  };

  void findSeams(const Cage& cage, const FaceBorders& faces, const std::vector<Vec2f>& uvs, const UdimTiles& tiles);
  void joinFaces(const FaceBorders& faces);
  void findEnds(const Cage& cage, const FaceBorders& faces, const std::vector<Vec2f>& uvs, const UdimTiles& tiles,
                bool repeats);
  void sortEnds(std::vector<std::vector<End>> endsOfCharts);

  std::vector<unsigned> charts; // per face
  unsigned numCharts = 0;
  std::vector<char> mirrored; // per face: clockwise, seen with v upward
  std::vector<char> differingEdges, differingCorners;
  std::vector<Grid> grids;      // per chart
  std::vector<size_t> firstEnd; // per cell, followed by the end
  std::vector<End> ends;
};

} // namespace programs
