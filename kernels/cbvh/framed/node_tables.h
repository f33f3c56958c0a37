// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tables for node_decoder4.h. One load per pair of planes replaces shifts, conversions and selects, and is the same on
 * every ISA. */

#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    struct alignas(64) NodeTables
    {
      /*! [axis][5 bits of the pair][child]: planes in parent extents. */
      float lowerPlane[2][32][4];
      float upperPlane[2][32][4];

      /*! [6 bits of a row's two children]: their lower planes, then their upper planes. */
      float zPair[64][4];

      float latticeOuter[32];

      /*! [corner]: for each leaf, the byte of the corner's height among the nine heights of a lattice, the middle one
       *  last. The other bytes of each lane are 0x80, so that a byte shuffle yields integers. */
      alignas(16) uint8_t latticeCorner[4][16];

      /*! Masks of four: each bit as the lowest of four bits, and as all four bits. */
      uint16_t firstOfFour[16], allOfFour[16];

      NodeTables ();
    };

    extern const NodeTables nodeTables;
  }
}
