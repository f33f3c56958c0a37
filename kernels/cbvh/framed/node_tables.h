// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Node planes of framed/node.h, expanded for the 4 children at once: one load from a small table a
 * plane pair instead of shifts, conversions and selects, the same on every ISA. */

#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    struct alignas(64) NodeTables
    {
      /*! [axis][5 bits of the pair][child]: planes in parent extents */
      float lowerPlane[2][32][4];
      float upperPlane[2][32][4];

      /*! [6 bits of a row's two children]: their lower planes, then their upper planes */
      float zPair[64][4];

      /*! outer planes of cLEAF's lattices, framed/leaf/format.h */
      float latticeOuter[32];

      /*! [corner]: for each leaf the byte of the corner's height among the nine of a lattice, the
       *  middle one last; the other bytes of the lane are 0x80, so that a byte shuffle makes integers */
      alignas(16) uint8_t latticeCorner[4][16];

      /*! masks of four, as the lowest bits of four bits each, and as all of them */
      uint16_t firstOfFour[16], allOfFour[16];

      NodeTables ();
    };

    extern const NodeTables nodeTables;
  }
}
