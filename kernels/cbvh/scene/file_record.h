// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the record of a geometry must satisfy. A writer checks it before it writes, a reader before it loads: so
 * whatever can be saved can be loaded. */

#include "../base/kinds.h"
#include "../base/surface_ids.h"
#include "../base/world.h"
#include "../vert/motion_format.h"
#include "file_format.h"
#include "surface_blocks.h"
#include <cmath>
#include <string>

namespace embree
{
  namespace cbvh
  {
    inline bool areBounds (const float lower[3], const float upper[3]) {
      return isFinite(lower) && isFinite(upper) && lower[0] <= upper[0] && lower[1] <= upper[1] && lower[2] <= upper[2];
    }

    /*! Returns what is wrong with a record, apart from where its tree and its blocks are; empty if nothing is. */
    inline std::string errorOfRecord (const FileGeometry& g)
    {
      if (g.form > FILE_MOVING || g.source > FILE_TRIANGLES) return "a form that is none";
      Kind kind;
      if (!findKind(int(g.compression),kind)) return "a compression that is none";
      const size_t of = g.form == FILE_TREE ? sizeof(FileNode) : sizeof(FileEntry);
      if (g.treeBytes % of != 0 || (g.form == FILE_TREE && g.treeBytes == 0)) return "a tree that is none";
      if (g.numBlocks > g.treeBytes/of*(g.form == FILE_TREE ? 4 : 1)) return "fewer leaves than blocks";
      const bool moves = g.form == FILE_MOVING;
      if (moves != (g.numTimeSteps != 1) || g.numTimeSteps == 0 || g.numTimeSteps > maxTimeSteps)
        return "a number of time steps that is none";
      if (moves && (!std::isfinite(g.begin) || !std::isfinite(g.end) || !(g.begin < g.end)))
        return "a time range that is none";
      if ((g.surface & firstFileNumber) == 0 || ((g.surface & movingSurface) != 0) != moves || g.surface == ~0u)
        return "a number of its surface that is none";
      const bool isEmpty = !(g.lower[0] <= g.upper[0] && g.lower[1] <= g.upper[1] && g.lower[2] <= g.upper[2]);
      if (g.numBlocks && !isEmpty && !areBounds(g.lower,g.upper)) return "bounds that are none";
      if (g.numBlocks && isEmpty && !moves) return "no bounds";
      return std::string();
    }
  }
}
