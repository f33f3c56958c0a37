// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The vertices along a side of a cage's patch: all of an edge, half of an n-gon's edge, or a spoke from there to the
 * n-gon's center. */

#include "shared_border.h"

namespace embree
{
  namespace isa
  {
    struct CageSide
    {
      SharedVertex begin, end;
      const float (*interior)[3]; //!< rate-1 positions, in the direction of the owner; CageBorders has them
      bool reversed;              //!< the owner's direction is the other one
      int exponent;               //!< of the interior's lattice
      unsigned rate;

      /*! Vertex k of 0 to rate, counted around the patch. */
      SharedVertex operator[] (unsigned k) const
      {
        if (k == 0) return begin;
        if (k == rate) return end;
        return SharedVertex(interior[(reversed ? rate-k : k) - 1],exponent);
      }

      /*! First or second half of an edge. Embree gives edges of n-gons an even rate in all faces that it knows next to
       *  them. On an edge of three faces a quad's rate may be odd. Then the vertex before the middle is the n-gon's, as
       *  in Embree's stitching; if the rate is 1, the first half is a point. */
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
