// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The border of a patch's grid of vertices as its face shares it with others: the positions that
 * the owners have, on the lattices that all have in common (shared_vertices.h). */

#include "shared_vertices.h"

namespace embree
{
  namespace isa
  {
    /*! Takes the shared vertices for the border of a patch. own, vertices: as the face evaluates them, and
     *  where to, row by row, quadsX+1 a row, may be the same; rate: becomes that of each side, in the order of
     *  PatchOfFace::rate, which may be lower than the patch's own; lower ones are stitched as Embree does it. Tells
     *  closure(own,shared,stored) of each vertex: as the face evaluated it, as its owner did, and on the lattice. */
    template<typename Closure>
    inline void shareBorder (const SharedVertices& shared, size_t face, const PatchOfFace& patch, unsigned quadsX, unsigned quadsY,
                             const float (*own)[3], float (*vertices)[3], float rate[4], const Closure& closure)
    {
      const size_t width = quadsX+1;
      for (int s=0; s<4; s++)
      {
        const SideVertices side = shared.side(face,patch.subPatch,s);
        rate[s] = float(side.rate);
        const unsigned fine = s % 2 == 0 ? quadsX : quadsY;
        for (unsigned i=0; i<=fine; i++)
        {
          const unsigned c = i == fine ? side.rate : cbvh::stitchedVertex(i,fine,side.rate);
          const SideVertices::Vertex v = side[s < 2 ? c : side.rate-c];
          const size_t x = s == 1 ? quadsX : s == 3 ? 0 : i, y = s == 0 ? 0 : s == 2 ? quadsY : i;
          const cbvh::WorldLattice common(v.exponent);
          const float* mine = own[y*width+x];
          float* out = vertices[y*width+x];
          /* a vertex that is not finite leaves out the quads of its own face, not those of others */
          const float* position = cbvh::isFinite(v.position) && cbvh::isFinite(mine) ? v.position : mine;
          const float snapped[3] = { common.snap(position[0]),common.snap(position[1]),common.snap(position[2]) };
          closure(mine,position,snapped);
          memcpy(out,snapped,sizeof(snapped));
        }
      }
    }
  }
}
