// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lookup tables of the SIMD decoders of cVERT: the order of a cell's vertices in lanes, and where the bit field of each
 * vertex is (cvert/format/cell.h). They are computed once, when the library is loaded. */

#include "../embree/simd.h"
#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    /*! Lane of the vertex in column i and row j of 5 x 5: the first four columns row by row, then the fifth column. The
     *  lower left corners of the 4 x 4 quads are then lanes 0 to 15, in the order of the quads. */
    __forceinline constexpr uint32_t laneOfVertex (uint32_t i, uint32_t j) { return i < 4 ? 4*j + i : 20 + j; }

    /*! Lane of corner c (column + 2 row) of quad q (column + 4 row). */
    __forceinline constexpr uint32_t laneOfCorner (uint32_t q, uint32_t c) {
      return laneOfVertex((q & 3) + (c & 1),(q >> 2) + (c >> 1));
    }

    struct alignas(64) VertTables
    {
      static const int lanes = 32; //!< 25 vertices, rounded up to two vectors of 16

      /*! Weights of the upper corner in a vertex's prediction (cellWeight), 0 to 1: [kind of cell][quads along the
       *  side, minus 1][lane]. Kind 0: a block's first cell, whose vertices are corners of groups. Kind 1: a group's
       *  cell. */
      float weightX[2][16][lanes];
      float weightY[2][16][lanes];

      int32_t field[lanes];      //!< index of the vertex's field; 0 for a corner, which has none
      int32_t hasField[lanes];   //!< mask: -1 for a vertex with a field, otherwise 0
      uint8_t laneOfField[24];   //!< inverse of `field`
      uint8_t corners[16][4];    //!< laneOfCorner(quad,corner)
      uint8_t triangles[32][4];  //!< lanes of the vertices of a triangle (cornerOfTriangle); the fourth is unused

      /*! Loads and shuffles that extract the fields of a cell, for one number of bits per field. A window is 16 bytes
       *  that contain the fields of a row's first four columns; a byte shuffle moves each field to its lane. */
      struct Windows
      {
        static const int rows = 5;
        alignas(16) uint8_t control[rows][16];  //!< shuffle: 4 bytes per lane, starting with the field's first byte
        alignas(16) uint8_t fifth[rows][16];    //!< shuffle: fifth byte of fields that extend over five bytes
        alignas(32) int32_t shift[4*rows];      //!< position of the field's first bit in its byte
        alignas(16) int32_t factor[4*rows];     //!< product moves the first bit to bit 7; SSE has no shifts per lane
        uint8_t offset[rows];                   //!< of the window, in bytes from the start of the first field
        /*! Byte and bit at which the field in the row's fifth column starts. Unused for the first and last row, where
         *  the fifth vertex is a corner. */
        uint8_t columnOffset[rows], columnShift[rows];
      };

      static const int maxWindowBits = 32;
      static const int maxBitsOfFour = 25; //!< largest field that fits into four bytes at any first bit 0 to 7
      static const int maxOverread = 8;    //!< largest number of bytes that windows read after the last field

      /*! False for numbers of bits without windows: windows of fields below 3 bits would read too far after the last
       *  field, and four fields of 31 bits can extend over 17 bytes. */
      static __forceinline bool hasWindows (int bits) { return bits >= 3 && bits != 31; }

      Windows windows[maxWindowBits+1];

      VertTables ();

    private:
      void setWindows (int bits);
    };

    extern const VertTables vertTables;
  }
}
