// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Shared vertices along a side of a cage's patch: an edge, half of an n-gon's edge, or a spoke (cage_borders.h). */

#include "shared_border.h"

namespace embree::isa {
struct CageSide {
  SharedVertex begin, end;
  const float (*interior)[3]; //!< rate-1 positions in the owner's direction; owned by CageBorders
  bool isReversed;            //!< the side runs against the owner's direction
  int exponent;               //!< exponent of the interior's lattice, or losslessExponent
  unsigned rate;              //!< quads along the side

  /*! Returns vertex k, from 0 to rate, counted around the patch. */
  SharedVertex operator[](unsigned k) const {
    if (k == 0) return begin;
    if (k == rate) return end;
    return SharedVertex(interior[(isReversed ? rate - k : k) - 1], exponent);
  }

  /*! Returns the first (0) or second (1) half of an n-gon's edge, counted around the face. The rate is even if
   *  half-edges are opposites, but an edge without opposites (cage_topology.h) can have the odd rate of a quad. The
   *  halves then meet at the vertex before the middle, as in Embree's stitching; if the rate is 1, the first half
   *  is a point. */
  CageSide half(int which) const {
    CageSide side = *this;
    const unsigned middle = rate / 2, rest = rate - middle;
    (which == 0 ? side.end : side.begin) = (*this)[middle];
    if ((which == 1) != isReversed) side.interior += which == 1 ? middle : rest;
    side.rate = which == 1 ? rest : max(middle, 1u);
    return side;
  }
};
} // namespace embree::isa
