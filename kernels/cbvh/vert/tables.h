// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Constants of a cVERT cell (cvert/format/cell.h), one lane per vertex, padded for vectors of any width. */

#include "../embree/simd.h"
#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    /*! Vertex (i,j): the first four columns row by row, then the fifth column. */
    __forceinline constexpr uint32_t laneOfVertex (uint32_t i, uint32_t j) { return i < 4 ? 4*j + i : 20 + j; }

    /*! Corner c (column + 2 row) of quad q of 4 x 4. */
    __forceinline constexpr uint32_t laneOfCorner (uint32_t q, uint32_t c) {
      return laneOfVertex((q & 3) + (c & 1),(q >> 2) + (c >> 1));
    }

    struct alignas(64) VertTables
    {
      static const int lanes = 32;

      /*! Weights of the upper corner, 0 to 1, by [0: cells of 4 groups, 1: cells of quads][quads along the side, minus
       *  1][lane]. */
      float weightX[2][16][lanes];
      float weightY[2][16][lanes];

      int32_t field[lanes];      //!< field of the vertex; 0 for a corner
      int32_t hasField[lanes];   //!< -1 for a vertex with a field, 0 for a corner
      uint8_t laneOfField[24];   //!< inverse of `field`
      uint8_t corners[16][4];    //!< as laneOfCorner
      uint8_t triangles[32][4];  //!< lanes of vertices (cornerOfTriangle), then 0

      /*! Positions of a cell's fields, for a number of bits. The first four columns of a row are in 16 bytes, which a
       *  shuffle distributes to lanes. */
      struct Windows
      {
        static const int rows = 5;
        alignas(16) uint8_t control[rows][16];  //!< shuffle of 4 bytes per lane, starting with the field's first byte
        alignas(16) uint8_t fifth[rows][16];    //!< shuffle of long fields' fifth byte
        alignas(32) int32_t shift[4*rows];      //!< field's first bit in its byte
        alignas(16) int32_t factor[4*rows];     //!< moves a field's first bit to bit 7
        uint8_t offset[rows];                   //!< from the start of the first field
        /*! Byte and bit of each row's field in the fifth column, if there is one. */
        uint8_t columnOffset[rows], columnShift[rows];
      };

      static const int maxWindowBits = 32;
      static const int maxBitsOfFour = 25; //!< largest field that fits into four bytes from any first bit
      static const int readPast = 8;       //!< bytes that windows read after the last field, at most

      /*! Windows of smaller fields would read too far after the last field. Four fields of 31 bits can span 17
       *  bytes. */
      static __forceinline bool hasWindows (int bits) { return bits >= 3 && bits != 31; }

      Windows windows[maxWindowBits+1];

      VertTables ();

    private:
      void setWindows (int bits);
    };

    extern const VertTables vertTables;
  }
}
