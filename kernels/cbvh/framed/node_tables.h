// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tables for node_decoder4.h. A load per pair of planes replaces shifts, conversions and selects, and is the same on
 * every ISA. */

#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    struct alignas(64) NodeTables
    {
      /*! [axis][pair][child]: planes in parent extents. */
      float lowerPlane[2][32][4];
      float upperPlane[2][32][4];

      /*! [6 bits of two children]: their lower planes, then their upper planes. */
      float zPair[64][4];

      float latticeOuter[32];

      /*! [corner]: per leaf, the byte of the corner's height among the nine heights of a lattice, the middle one last.
       *  Other bytes of each lane are 0x80, so that byte shuffles return integers. */
      alignas(16) uint8_t latticeCorner[4][16];

      /*! Each bit as the lowest of four bits, and as all four. */
      uint16_t firstOfFour[16], allOfFour[16];

      NodeTables ();
    };

    extern const NodeTables nodeTables;
  }
}
