// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled once, for the library's lowest instruction set, because it runs when the library is loaded. */

#include "node_tables.h"
#include "leaf/format.h"

namespace embree::cbvh {
const NodeTables nodeTables;

NodeTables::NodeTables() {
  for (int axis = 0; axis < 2; axis++)
    for (uint32_t pair = 0; pair < 32; pair++)
      for (int child = 0; child < 4; child++) {
        lowerPlanes[axis][pair][child] = lowerPlane(pair, childCoordinate(child, axis));
        upperPlanes[axis][pair][child] = upperPlane(pair, childCoordinate(child, axis));
      }
  for (uint32_t codes = 0; codes < 64; codes++)
    for (int child = 0; child < 2; child++) {
      const Interval z = zInterval((codes >> (zBits * child)) & 7);
      zPlanes[codes][child] = z.lower;
      zPlanes[codes][child + 2] = z.upper;
    }
  for (uint32_t code = 0; code < 32; code++) latticeOuterOffsets[code] = latticeOuterOffset(code);
  for (int corner = 0; corner < 4; corner++)
    for (int byte = 0; byte < 16; byte++) {
      const int child = byte / 4;
      const int vertex = childCoordinate(child, 0) + childCoordinate(corner, 0) +
                         3 * (childCoordinate(child, 1) + childCoordinate(corner, 1));
      latticeCornerShuffles[corner][byte] = uint8_t(byte % 4 ? 0x80 : vertex == 4 ? 8 : latticeByte(vertex));
    }
  for (int mask = 0; mask < 16; mask++) {
    firstOfFour[mask] = uint16_t((mask & 1) | (mask & 2) << 3 | (mask & 4) << 6 | (mask & 8) << 9);
    allOfFour[mask] = uint16_t(15 * firstOfFour[mask]);
  }
}
} // namespace embree::cbvh
