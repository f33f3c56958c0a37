// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a source of surfaces gives to the writers of blocks: patches, each a grid of quads of one primitive, with their
 * vertices and what neighbours share. Cages are a source (cage_patch.h), and grids that an application diced (grid_patch.h). A writer
 * (vert/writer.h, framed/writer.h) takes a patch of any source; besides SurfacePatch it has
 *
 *   VertexGrid& evaluate (unsigned quadsX, unsigned quadsY, const PatchPart& part, unsigned step)
 *       Vertices of a part of the patch at a time step, if that has quadsX x quadsY quads, not fewer than its own. Edges of a lower rate are
 *       stitched as Embree does it. What is returned is the caller's until the next call.
 *   side (int s, unsigned step)
 *       Vertices of a side, in the order of rate, as all primitives have them that share it: .rate, and of vertex [k], counted around
 *       the patch, .position and .exponent, of the lattice that it lies on.
 *   int latticeExponent (unsigned step)
 *       Of the lattice of the patch's own vertices. */

#include "../base/codec.h"
#include "../../cvert/encoder/numbers_encoder.h"
#include "vertex_grid.h"

namespace embree
{
  namespace isa
  {
    /*! Vertices along one side of a patch, in its direction around the patch. */
    struct SideVertices
    {
      struct Vertex
      {
        const float* position;
        int exponent;          //!< of the lattice that it lies on
      };
      Vertex begin, end;
      const float (*interior)[3]; //!< of rate-1
      bool reversed;
      int exponent;            //!< of the interior's
      unsigned rate;

      Vertex operator[] (unsigned k) const
      {
        if (k == 0) return begin;
        if (k == rate) return end;
        return { interior[(reversed ? rate-k : k) - 1], exponent };
      }
    };

    static const unsigned looseSide = 4; //!< quads of a mesh that lie in no grid of so many along each side are loose

    struct SurfacePatch
    {
      uint32_t surface;     //!< its number, surface_ids.h
      unsigned primID;
      unsigned corner[2];   //!< parameters of the primitive at the patch's corner, in halves
      unsigned quads[2];    //!< along u and v: the higher rate of two opposite edges
      const float* rate;    //!< of the edges v = 0, u = 1, v = 1, u = 0
      const cbvh::QuadNumbers* numbers = nullptr; //!< null where the patch is of one primitive
    };
  }
}
