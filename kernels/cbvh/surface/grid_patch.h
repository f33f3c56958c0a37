// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A grid of a grid geometry, or a region of a mesh, as a patch (source.h). */

#include "grid_borders.h"
#include "source.h"

namespace embree::isa {
/*! Grids: see diced_grids.h. */
template<typename Grids>
class GridPatch : public SurfacePatch {
  typedef GridBorders<Grids> Borders;

public:
  struct Scratch : public PatchVertices {
    explicit Scratch(Device* device) : PatchVertices(device) {}
    cbvh::QuadNumbers numbers;
  };

  GridPatch(const Borders& borders, uint32_t surfaceNumber, size_t grid, Scratch& scratch)
    : borders(borders),
      grid(borders[grid]),
      scratch(scratch) {
    this->surfaceNumber = surfaceNumber;
    primID = unsigned(grid);
    corner[0] = corner[1] = 0;
    for (int d = 0; d < 2; d++) quads[d] = this->grid.quads(d);
    for (int s = 0; s < 4; s++) rates[s] = float(quads[s & 1]);
    rate = rates;
    if (borders.getNumbers(grid, scratch.numbers)) numbers = &scratch.numbers;
  }

  GridPatch(const GridPatch& other, Scratch& scratch)
    : GridPatch(other.borders, other.surfaceNumber, other.primID, scratch) {}

  PatchVertices& evaluate(unsigned, unsigned, const PatchPart& part, unsigned step) {
    scratch.setSize(part);
    float(*out)[3] = scratch.displaced();
    for (unsigned y = part.y0; y <= part.y1; y++)
      for (unsigned x = part.x0; x <= part.x1; x++)
        memcpy(*out++, borders.position(grid.vertex(x, y), step), sizeof(*out));
    return scratch;
  }

  struct Side {
    const GridPatch& patch;
    int s;
    unsigned step, rate;
    SharedVertex operator[](unsigned k) const {
      return patch.borders.sharedVertex(patch.grid.sideVertex(s, k), patch.latticeExponent(step), step);
    }
  };
  Side side(int s, unsigned step) const { return Side{*this, s, step, quads[s & 1]}; }

  int latticeExponent(unsigned step) const { return borders.exponent(primID, step); }

private:
  const Borders& borders;
  const typename Borders::Grid grid;
  Scratch& scratch;
  float rates[4];
};
} // namespace embree::isa
