// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Node planes of node_codec.h, expanded for the 4 children at once: one load
 * from a small table a plane pair instead of shifts, conversions and selects, the
 * same on every ISA.
 *
 * Traversal mirrors each axis along which the ray descends (x -> 1-x), so that
 * every ray ascends on every axis: the near plane is always the lower one and
 * children come front to back in lane order. Lane l holds child l ^ flip, where
 * bit 0 (1) of flip mirrors x (y). The tables exist for both orientations; a ray
 * picks its pointers and shifts once a block. */

#include "node_codec.h"

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

      NodeTables()
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
                const Interval z = zIntervals[(pair >> (zBits*(lane ^ flipX))) & 7];
                zPair[flipX][flipZ][pair][lane  ] = flipZ ? 1.0f - z.upper : z.lower;
                zPair[flipX][flipZ][pair][lane+2] = flipZ ? 1.0f - z.lower : z.upper;
              }
      }
    };
  }
}
