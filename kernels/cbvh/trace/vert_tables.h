// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What is known beforehand of the 25 vertices of a cell of cVERT, codec/vertex_cell.h, a lane
 * each. Behind the last come lanes without a meaning, so that vectors of any width fit. */

#include "../../../common/sys/platform.h"
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

      /*! Where the fields of a cell are, for one number of bits a field: those of four lanes lie in 16
       *  bytes, which a shuffle takes apart. */
      struct Windows
      {
        alignas(16) uint8_t control[lanes/4][16]; //!< of the shuffle: a lane's 4 bytes begin with its field's first bit
        alignas(16) uint8_t fifth[lanes/4][16];   //!< of that of the bytes behind, which fields of many bits reach into
        alignas(32) int32_t shift[lanes];         //!< of the first bit in its byte
        alignas(16) int32_t factor[lanes];        //!< moves a lane's field to bit 7
        uint8_t offset[lanes/4];                  //!< bytes from the first field
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
