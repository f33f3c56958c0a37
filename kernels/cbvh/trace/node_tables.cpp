// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only: code that runs when the library is
 * loaded must run everywhere. */

#include "node_tables.h"
#include "../codec/leaf.h"

namespace embree
{
  namespace cbvh
  {
    const NodeTables nodeTables;

    NodeTables::NodeTables ()
    {
      for (int axis=0; axis<2; axis++)
        for (int flip=0; flip<2; flip++)
          for (uint32_t pair=0; pair<32; pair++)
            for (int lane=0; lane<4; lane++)
            {
              const int column = childColumn(lane,axis) ^ flip;
              nearPlane[axis][flip][pair][lane] = flip ? 1.0f - upperPlane(pair,column) : lowerPlane(pair,column);
              farPlane [axis][flip][pair][lane] = flip ? 1.0f - lowerPlane(pair,column) : upperPlane(pair,column);
            }
      for (int flipX=0; flipX<2; flipX++)
        for (int flipZ=0; flipZ<2; flipZ++)
          for (uint32_t pair=0; pair<64; pair++)
            for (int lane=0; lane<2; lane++)
            {
              const Interval z = zInterval((pair >> (zBits*(lane ^ flipX))) & 7);
              zPair[flipX][flipZ][pair][lane  ] = flipZ ? 1.0f - z.upper : z.lower;
              zPair[flipX][flipZ][pair][lane+2] = flipZ ? 1.0f - z.lower : z.upper;
            }
      for (uint32_t code=0; code<32; code++)
        latticeOuter[code] = cbvh::latticeOuter(code);
      for (int flip=0; flip<4; flip++)
        for (int corner=0; corner<4; corner++)
          for (int byte=0; byte<16; byte++)
          {
            const int child = (byte/4) ^ flip, c = corner ^ flip;
            const int vertex = childColumn(child,0)+childColumn(c,0) + 3*(childColumn(child,1)+childColumn(c,1));
            latticeCorner[flip][corner][byte] = uint8_t(byte % 4 ? 0x80 : vertex == 4 ? 8 : latticeByte(vertex));
          }
    }
  }
}
