// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a source of surfaces gives to the writers of blocks: patches, each a grid of quads of one face, with their
 * vertices and what neighbours share. Cages are a source (cage_patch.h). A writer (vert/writer.h, framed/writer.h) knows of
 * no other surface than this. */

#include "vertex_grid.h"

namespace embree
{
  struct SubdivPatch1Base;

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

    class SurfacePatch
    {
    public:
      uint32_t surface;     //!< its number, surface_ids.h
      unsigned primID;
      unsigned corner[2];   //!< parameters of the face at the patch's corner, in halves
      unsigned quads[2];    //!< along u and v: the higher rate of two opposite edges
      const float* rate;    //!< of the edges v = 0, u = 1, v = 1, u = 0

      /*! Vertices of a part of the patch, if that has quadsX x quadsY quads, not fewer than its own. Edges of a lower rate are
       *  stitched as Embree does it. What is returned is the caller's until the next call. */
      virtual VertexGrid& evaluate (unsigned quadsX, unsigned quadsY, const PatchPart& part, unsigned timeStep = 0) = 0;

      /*! of sources whose faces share vertices: those of a side, as all faces have them; sides are in the order of rate */
      virtual SideVertices side (int s) const = 0;

      /*! exponent of the face's lattice, of such sources */
      virtual int latticeExponent () const = 0;

      /*! bits of sides where the surface ends, is creased, or bends by as much as at a crease */
      virtual uint32_t sharpSides () const = 0;

      /*! the patch as Embree has it, or null: for parts that are left to GRID */
      virtual const SubdivPatch1Base* ofEmbree () const { return nullptr; }

    protected:
      ~SurfacePatch () {}
    };
  }
}
