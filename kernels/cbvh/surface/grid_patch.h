// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A grid that an application diced, as writers see it: its vertices are the application's own. */

#include "grid_vertices.h"
#include "source.h"

namespace embree
{
  namespace isa
  {
    /*! Grids: see diced_grids.h */
    template<typename Grids>
    class GridPatch : public SurfacePatch
    {
      typedef GridVertices<Grids> Vertices;

    public:
      /*! of a task */
      struct Scratch : public VertexGrid
      {
        explicit Scratch (Device* device) : VertexGrid(device) {}
        void setSize (size_t w, size_t h) { width = w; height = h; resize(); }
        cbvh::QuadNumbers numbers;
      };

      GridPatch (const Vertices& vertices, uint32_t surface, size_t grid, Scratch& scratch)
        : vertices(vertices), grid(vertices[grid]), scratch(scratch)
      {
        this->surface = surface;
        primID = unsigned(grid);
        corner[0] = corner[1] = 0;
        for (int d=0; d<2; d++) quads[d] = this->grid.quads(d);
        for (int s=0; s<4; s++) rates[s] = float(quads[s & 1]);
        rate = rates;
        if (vertices.number(grid,scratch.numbers)) numbers = &scratch.numbers;
      }

      /*! the same patch for another task */
      GridPatch (const GridPatch& other, Scratch& scratch) : GridPatch(other.vertices,other.surface,other.primID,scratch) {}

      VertexGrid& evaluate (unsigned, unsigned, const PatchPart& part, unsigned step = 0)
      {
        scratch.setSize(part.x1-part.x0+1,part.y1-part.y0+1);
        float (*out)[3] = scratch.displaced();
        for (unsigned y=part.y0; y<=part.y1; y++)
          for (unsigned x=part.x0; x<=part.x1; x++)
            memcpy(*out++,vertices.position(grid.vertex(x,y),step),sizeof(*out));
        return scratch;
      }

      class Side
      {
      public:
        unsigned rate;
        Side (const GridPatch& patch, int s, unsigned step) : rate(patch.quads[s & 1]), patch(patch), s(s), step(step) {}
        typename Vertices::Shared operator[] (unsigned k) const { return patch.vertices.shared(patch.grid.onSide(s,k),patch.latticeExponent(step),step); }

      private:
        const GridPatch& patch;
        const int s;
        const unsigned step;
      };
      Side side (int s, unsigned step = 0) const { return Side(*this,s,step); }

      int latticeExponent (unsigned step = 0) const { return vertices.exponent(primID,step); }

    private:
      const Vertices& vertices;
      const typename Vertices::Grid grid;
      Scratch& scratch;
      float rates[4];
    };
  }
}
