// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What is known beforehand of the 25 vertices of a cell of cVERT, cvert/format/cell.h, a lane
 * each. Behind the last come lanes without a meaning, so that vectors of any width fit. */

#include "../embree/simd.h"
#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    /*! lane of vertex (i,j) of a cell: the first four columns row by row, then the fifth */
    __forceinline constexpr uint32_t laneOfVertex (uint32_t i, uint32_t j) { return i < 4 ? 4*j + i : 20 + j; }

    /*! that of corner c (column + 2 row) of quad q of 4 x 4 */
    __forceinline constexpr uint32_t laneOfCorner (uint32_t q, uint32_t c) { return laneOfVertex((q & 3) + (c & 1),(q >> 2) + (c >> 1)); }

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
      uint8_t corners[16][4];    //!< lanes of the corners of each of 4 x 4 quads: laneOfCorner
      uint8_t triangles[32][4];  //!< lanes of the vertices of each triangle of a group, cornerOfTriangle; and 0

      /*! Where the fields of a cell are, for one number of bits a field: those of the first four columns of a row lie in 16
       *  bytes, which a shuffle takes apart. */
      struct Windows
      {
        static const int rows = 5;
        alignas(16) uint8_t control[rows][16];  //!< of the shuffle: a lane's 4 bytes begin with its field's first bit
        alignas(16) uint8_t fifth[rows][16];    //!< of that of the bytes behind, which fields of many bits reach into
        alignas(32) int32_t shift[4*rows];      //!< of the first bit in its byte
        alignas(16) int32_t factor[4*rows];     //!< moves a lane's field to bit 7
        uint8_t offset[rows];                   //!< bytes from the first field
        uint8_t columnOffset[rows], columnShift[rows]; //!< byte and bit of each row's field of the fifth column, if there is one
      };

      static const int maxWindowBits = 32;
      static const int maxBitsOfFour = 25; //!< that four bytes have, wherever in the first of them a field begins
      static const int readBehind = 8;     //!< bytes that windows have behind the last field, at most

      /*! whether windows are made for fields of so many bits: those of fewer reach too far behind the last
       *  field, and four fields of 31 may have 17 bytes */
      static __forceinline bool hasWindows (int bits) { return bits >= 3 && bits != 31; }

      Windows windows[maxWindowBits+1];

      VertTables ();

    private:
      void setWindows (int bits);
    };

    extern const VertTables vertTables;
  }
}
