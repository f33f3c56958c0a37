// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Node planes of codec/node.h, expanded for the 4 children at once: one load
 * from a small table a plane pair instead of shifts, conversions and selects, the
 * same on every ISA.
 *
 * Traversal mirrors each axis along which the ray descends (x -> 1-x), so that
 * every ray ascends on every axis: the near plane is always the lower one and
 * children come front to back in lane order. Lane l holds child l ^ flip, where
 * bit 0 (1) of flip mirrors x (y). The tables exist for both orientations; a ray
 * picks its pointers and shifts once a block. */

#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    struct alignas(64) NodeTables
    {
      /*! [axis][mirrored][5 bits of the pair][lane]: planes in parent extents */
      float nearPlane[2][2][32][4];
      float farPlane [2][2][32][4];

      /*! [x mirrored][z mirrored][6 bits of a row's two children]: lower planes of the
       *  row's two lanes, then their upper planes */
      float zPair[2][2][64][4];

      /*! outer planes of cLEAF's lattices, codec/leaf.h */
      float latticeOuter[32];

      /*! [mirrored x + 2 mirrored y][corner]: for each lane the byte of the corner's height among
       *  the nine of a lattice, the middle one last; the other bytes of the lane are 0x80, so
       *  that a byte shuffle makes integers */
      alignas(16) uint8_t latticeCorner[4][4][16];

      NodeTables ();
    };

    extern const NodeTables nodeTables;
  }
}
