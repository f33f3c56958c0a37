// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tables of planes and masks, computed when the library is loaded. One load per pair of planes replaces shifts,
 * conversions and selects, and returns the same floats on every instruction set. */

#include <cstdint>

namespace embree::cbvh {
struct alignas(64) NodeTables {
  /*! [x or y][plane pair][child]: lowerPlane() and upperPlane() of node.h, in parent extents. */
  float lowerPlanes[2][32][4];
  float upperPlanes[2][32][4];

  /*! [z codes of two children]: their lower planes in z, then their upper planes, in parent extents. */
  float zPlanes[64][4];

  float latticeOuterOffsets[32]; //!< [code]: latticeOuterOffset() of leaf/format.h

  /*! [corner]: control of a byte shuffle of a lattice's nine heights, the middle one last. It returns the corner's
   *  height of each of the four leaves as a 32-bit integer; 0x80 selects 0. */
  alignas(16) uint8_t latticeCornerShuffles[4][16];

  /*! [mask of children]: mask of their first grandchildren, or of all their grandchildren. */
  uint16_t firstOfFour[16], allOfFour[16];

  NodeTables();
};

extern const NodeTables nodeTables;
} // namespace embree::cbvh
