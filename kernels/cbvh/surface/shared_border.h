// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The border of a patch as its face shares it with others: the positions that
 * the owners have, on the lattices that all have in common (shared_vertices.h, grid_vertices.h). */

#include "../base/codec.h"
#include "../../cvert/format/block.h"
#include "../../cvert/encoder/lattice.h"
#include "vertex_grid.h"

namespace embree
{
  namespace isa
  {
    /*! Replaces the vertices of a part that are on the border of a patch of quadsX x quadsY quads at a time step by those that the faces there share.
     *  own: as the face evaluates them; vertices: the result; both row by row of the part, and they may be the same. A side whose rate
     *  is lower than the patch's quads is stitched as Embree stitches it. Calls closure(own,shared,stored) for each of these vertices: as
     *  the face evaluated it, as its owner did, and on the lattice. */
    template<typename Patch, typename Closure>
    inline void shareBorder (const Patch& patch, unsigned step, unsigned quadsX, unsigned quadsY, const PatchPart& part,
                             const float (*own)[3], float (*vertices)[3], const Closure& closure)
    {
      const size_t width = part.x1-part.x0+1;
      for (int s=0; s<4; s++)
      {
        const bool alongU = s % 2 == 0;
        const unsigned at = s == 1 ? quadsX : s == 2 ? quadsY : 0; // the row or the column of the side
        if (alongU ? at < part.y0 || at > part.y1 : at < part.x0 || at > part.x1) continue;
        const auto side = patch.side(s,step);
        const unsigned fine = alongU ? quadsX : quadsY;
        const unsigned begin = alongU ? part.x0 : part.y0, end = alongU ? part.x1 : part.y1;
        for (unsigned i=begin; i<=end; i++)
        {
          const unsigned c = i == fine ? side.rate : cbvh::stitchedVertex(i,fine,side.rate);
          const auto v = side[s < 2 ? c : side.rate-c];
          const size_t vertex = alongU ? (at-part.y0)*width + (i-part.x0) : (i-part.y0)*width + (at-part.x0);
          const cbvh::WorldLattice common(v.exponent);
          const float* mine = own[vertex];
          /* a vertex that is not finite leaves out the quads of its own face, not those of others */
          const float* position = cbvh::isFinite(v.position) && cbvh::isFinite(mine) ? v.position : mine;
          const float snapped[3] = { common.snap(position[0]),common.snap(position[1]),common.snap(position[2]) };
          closure(mine,position,snapped);
          memcpy(vertices[vertex],snapped,sizeof(snapped));
        }
      }
    }
  }
}
