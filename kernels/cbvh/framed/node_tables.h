// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tables for node_decoder4.h and tile_hits.h, computed when the library is loaded. One load per pair of planes replaces
 * shifts, conversions and selects, and returns the same floats on every instruction set. */

#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    struct alignas(64) NodeTables
    {
      /*! [axis][plane pair][child]: planes in parent extents, see lowerPlane() and upperPlane() in node.h. */
      float lowerPlane[2][32][4];
      float upperPlane[2][32][4];

      /*! [z codes of two children]: their lower planes in z, then their upper planes, in parent extents. */
      float zPair[64][4];

      float latticeOuter[32]; //!< latticeOuter() of leaf/format.h

      /*! [corner][4*leaf]: index of the corner's height among the nine heights of a lattice, the middle one last. Bytes
       *  in between are 0x80, so that byte shuffles return integers. */
      alignas(16) uint8_t latticeCorner[4][16];

      /*! Expand each of four mask bits to four bits: to the lowest only, or to all. */
      uint16_t firstOfFour[16], allOfFour[16];

      NodeTables ();
    };

    extern const NodeTables nodeTables;
  }
}
