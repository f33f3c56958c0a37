// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The rule of shared borders.
 *
 * The primitives of a geometry, faces or grids, meet along edges and in corners. Each evaluates its vertices there by
 * itself, and rounds its own vertices to its own lattice. Rays would slip through the gaps between the results. So all
 * primitives store the same floats there, and the surface is closed by sharing:
 *
 *  1. Owner. One primitive owns a shared edge, and one owns a shared corner: the one with the least claim. A primitive
 *     that GRID traces comes first, because GRID cannot be given other vertices. Then comes the primitive with the
 *     fewest vertices along the edge, then the lower number. The owner's positions are the positions of all.
 *  2. Rate. An edge has the lowest of the rates that its primitives have there. A primitive with more vertices is
 *     stitched to it: each of its vertices moves to one of the edge's.
 *  3. Lattice. A shared vertex lies on the coarsest of the lattices of its primitives (border_lattices.h). It is a
 *     point of all of them, as lattices are nested. A vertex that GRID has lies on no lattice: it stays where it is.
 *  4. Vertices on an edge. Where an application moved the vertices of a fine grid onto the edges of a coarse one, they
 *     are stored on these edges as stored, and on no lattice (stitched_vertices.h).
 *  5. Values that are not finite. A primitive that has one at its border keeps it, and leaves out its own quads. It
 *     does not pass the value on, nor does it lose quads for the value of an owner.
 *  6. Time. Owners, rates and shared vertices are the same at all time steps; positions and lattices are not.
 *
 * Grids need no owner and no common rate, because vertices that they share are equal floats.
 *
 * Where the topology comes from is not part of the rule. Cages have half-edges: cage_topology.h finds owners and rates,
 * cage_borders.h evaluates what is owned. Grids and the regions of meshes have equal floats: grid_borders.h. */

#include "../base/build_statistics.h"
#include "../base/codec.h"
#include "../../cvert/encoder/lattice.h"
#include "../../cvert/format/block.h"
#include "patch_vertices.h"

namespace embree
{
  namespace isa
  {
    /*! a vertex on a border, as all primitives have it that share it */
    struct SharedVertex
    {
      float position[3]; //!< before it is rounded
      int exponent;      //!< of the lattice that it lies on, or exactLattice

      SharedVertex () {}
      SharedVertex (const float p[3], int exponent) : position{ p[0],p[1],p[2] }, exponent(exponent) {}
    };

    /*! Claim of a primitive to own an edge or a corner; the least one owns it. rate: of the edge, below 2^31, and 0 for
     *  a corner, whose owner does not depend on it; number: unique among those that claim. */
    inline uint64_t claimOf (bool isTracedByGrid, unsigned rate, uint32_t number) {
      return uint64_t(!isTracedByGrid) << 63 | uint64_t(rate) << 32 | number;
    }

    /*! First of the vertices of a border of `fine` quads that cvert::stitchedVertex, like Embree's stitch(), moves to
     *  vertex k of an edge of a lower rate. It is the nearest one to it. */
    inline unsigned firstStitched (unsigned k, unsigned fine, unsigned coarse) {
      return (2*k*fine + coarse-1)/(2*coarse);
    }

    /*! Vertex of an edge of the rate `own` that is nearest to vertex k of the same edge at a rate not above it. */
    inline unsigned nearestVertex (unsigned k, unsigned rate, unsigned own) { return (2*k*own + rate)/(2*rate); }

    /*! Replaces the vertices of a part that lie on the border of a patch of quadsX x quadsY quads by the shared ones,
     *  rounded to their lattices, and adds how far they moved, and how far the owner's positions differ, to the
     *  statistics. own: as the primitive evaluates them; stored: the result. Both are row by row of the part and may be
     *  the same. Patch: see source.h. */
    template<typename Patch>
    inline void shareBorder (const Patch& patch, unsigned step, unsigned quadsX, unsigned quadsY, const PatchPart& part,
                             const float (*own)[3], float (*stored)[3], cbvh::BuildStatistics& statistics)
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
          const SharedVertex v = side[s < 2 ? c : side.rate-c];
          const size_t vertex = alongU ? (at-part.y0)*width + (i-part.x0) : (i-part.y0)*width + (at-part.x0);
          const cbvh::WorldLattice common(v.exponent);
          const float* mine = own[vertex];
          const float* position = cbvh::isFinite(v.position) && cbvh::isFinite(mine) ? v.position : mine;
          const float snapped[3] = { common.snap(position[0]),common.snap(position[1]),common.snap(position[2]) };
          statistics.addBorderVertex(mine,position,snapped);
          memcpy(stored[vertex],snapped,sizeof(snapped));
        }
      }
    }
  }
}
