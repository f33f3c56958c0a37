// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A patch of a cage (source.h): a face with four corners, or the part of another face at one of its corners. */

#include "cage_borders.h"
#include "source.h"

namespace embree::isa {
class CagePatch : public SurfacePatch {
public:
  /*! The arguments must outlive the object. `patch` is valid during forEachPatch's closure (patches.h). borders:
   *  null if the plan shares no borders. side(), latticeExponent() and cachedVertices() must then not be called. */
  CagePatch(SubdivMesh* mesh, uint32_t surfaceNumber, size_t face, const PatchOfFace& patch, const CageBorders* borders,
            PatchEvaluator& evaluator)
    : mesh(mesh),
      patch(patch),
      borders(borders),
      evaluator(evaluator),
      base(patch.make(mesh, surfaceNumber, face)) {
    this->surfaceNumber = surfaceNumber;
    primID = unsigned(face);
    corner[0] = unsigned(2 * base.getUV(0).x);
    corner[1] = unsigned(2 * base.getUV(0).y);
    const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
    quads[0] = unsigned(size.x - 1);
    quads[1] = unsigned(size.y - 1);
    rate = patch.rate;
  }

  CagePatch(const CagePatch& other, PatchEvaluator& evaluator)
    : SurfacePatch(other),
      mesh(other.mesh),
      patch(other.patch),
      borders(other.borders),
      evaluator(evaluator),
      base(other.base) {}

  PatchVertices& evaluate(unsigned quadsX, unsigned quadsY, const PatchPart& part, unsigned step) {
    if (!mesh->valid(primID, step)) evaluator.setInvalid(part);
    else if (step == 0) evaluator.evalPart(base, mesh, quadsX, quadsY, part);
    else evaluator.evalPart(patch.make(mesh, surfaceNumber, primID, step), mesh, quadsX, quadsY, part);
    return evaluator;
  }

  /*! See CageBorders. */
  const float (*cachedVertices(unsigned step) const)[3] {
    return borders->cachedVertices(primID, patch.subPatch, step);
  }

  CageSide side(int s, unsigned step) const { return borders->side(primID, patch.subPatch, s, step); }
  int latticeExponent(unsigned step) const { return borders->exponent(primID, step); }

  /*! Bit mask of the sides where the surface ends or bends, see sharpSidesOf(). */
  uint32_t sharpSides() const { return sharpSidesOf(mesh, primID, patch); }

  /*! Embree's form of the patch at the first time step. */
  const SubdivPatch1Base& embreePatch() const { return base; }

private:
  SubdivMesh* mesh;
  const PatchOfFace& patch;
  const CageBorders* borders;
  PatchEvaluator& evaluator;
  const SubdivPatch1Base base;
};
} // namespace embree::isa
