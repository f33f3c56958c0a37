// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Patches of a cage, as writers see them. */

#include "shared_vertices.h"
#include "source.h"

namespace embree
{
  namespace isa
  {
    class CagePatch : public SurfacePatch
    {
    public:
      /*! shared: of faces that share their borders, else null; grid: for vertices */
      CagePatch (SubdivMesh* mesh, uint32_t surface, size_t face, const PatchOfFace& patch, const SharedVertices* shared, PatchGrid& grid)
        : mesh(mesh), patch(patch), shared(shared), grid(grid), base(patch.make(mesh,surface,face))
      {
        this->surface = surface;
        primID = unsigned(face);
        corner[0] = unsigned(2*base.getUV(0).x);
        corner[1] = unsigned(2*base.getUV(0).y);
        const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
        quads[0] = unsigned(size.x-1);
        quads[1] = unsigned(size.y-1);
        rate = patch.rate;
      }

      /*! the same patch for another task, with a grid of its own */
      CagePatch (const CagePatch& other, PatchGrid& grid)
        : SurfacePatch(other), mesh(other.mesh), patch(other.patch), shared(other.shared), grid(grid), base(other.base) {}

      VertexGrid& evaluate (unsigned quadsX, unsigned quadsY, const PatchPart& part, unsigned step = 0)
      {
        if (!mesh->valid(primID,step)) grid.setInvalid(part);
        else if (step == 0) grid.evalPart(base,mesh,quadsX,quadsY,part);
        else grid.evalPart(patch.make(mesh,surface,primID,step),mesh,quadsX,quadsY,part);
        return grid;
      }

      /*! its vertices, if they are known, else null */
      const float (*evaluated (unsigned step = 0) const)[3] { return shared->evaluated(primID,patch.subPatch,step); }

      SideVertices side (int s, unsigned step = 0) const { return shared->side(primID,patch.subPatch,s,step); }
      int latticeExponent (unsigned step = 0) const { return shared->exponent(primID,step); }

      /*! bits of sides where the surface ends, is creased, or bends by as much as at a crease */
      uint32_t sharpSides () const { return sharpSidesOf(mesh,primID,patch); }

      /*! as Embree has it, for parts that are left to GRID */
      const SubdivPatch1Base& ofEmbree () const { return base; }

    private:
      SubdivMesh* mesh;
      const PatchOfFace& patch;
      const SharedVertices* shared;
      PatchGrid& grid;
      const SubdivPatch1Base base;
    };
  }
}
