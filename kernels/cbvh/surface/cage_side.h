// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The vertices along a side of a patch of a cage: an edge, half of the edge of an n-gon, or a spoke from there to the
 * n-gon's center. */

#include "shared_border.h"

namespace embree
{
  namespace isa
  {
    struct CageSide
    {
      SharedVertex begin, end;
      const float (*interior)[3]; //!< rate-1 positions in the owner's direction, stored in CageBorders
      bool reversed;              //!< the side runs against the owner's direction
      int exponent;               //!< lattice of the interior
      unsigned rate;

      /*! Returns vertex k, 0 to rate, counted around the patch. */
      SharedVertex operator[] (unsigned k) const
      {
        if (k == 0) return begin;
        if (k == rate) return end;
        return SharedVertex(interior[(reversed ? rate-k : k) - 1],exponent);
      }

      /*! Returns the first or the second half of an edge. Embree gives edges of n-gons an even rate in all faces that
       *  it connects to them. On an edge of three faces, the rate of a quad can be odd. The n-gon then uses the vertex
       *  before the middle, as in Embree's stitching; if the rate is 1, the first half is a point. */
      CageSide half (int which) const
      {
        CageSide side = *this;
        const unsigned middle = rate/2, rest = rate-middle;
        (which == 0 ? side.end : side.begin) = (*this)[middle];
        if ((which == 1) != reversed) side.interior += which == 1 ? middle : rest;
        side.rate = which == 1 ? rest : max(middle,1u);
        return side;
      }
    };
  }
}
