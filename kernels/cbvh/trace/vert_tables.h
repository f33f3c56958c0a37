// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What is known beforehand of the 25 vertices of a cell of cVERT, codec/vertex_cell.h, a lane
 * each. Behind the last come lanes without a meaning, so that vectors of any width fit. */

#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    struct alignas(64) VertTables
    {
      static const int lanes = 32;

      /*! [0: of 4 groups, 1: of quads][quads along the side, less 1][lane]: weights of the upper
       *  corner along x and along y, from 0 to 1 */
      float weightX[2][16][lanes];
      float weightY[2][16][lanes];

      int32_t field[lanes];      //!< of the vertex; 0 of a corner
      int32_t hasField[lanes];   //!< -1, or 0 of a corner
      uint8_t laneOfField[24];   //!< the inverse

      VertTables ();
    };

    extern const VertTables vertTables;
  }
}
