// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lookup tables of the SIMD decoders of cVERT, computed when the library is loaded: the lanes of a cell's vertices, and
 * where their bit fields are (cvert/format/cell.h). */

#include "../embree/simd.h"
#include <cstdint>

namespace embree::cbvh {
/*! Lane of the vertex in column i and row j of 5 x 5: the first four columns row by row, then the fifth column.
 *  Lanes 0 to 15 are the lower left corners of the quads. */
__forceinline constexpr uint32_t laneOfVertex(uint32_t i, uint32_t j) { return i < 4 ? 4 * j + i : 20 + j; }

/*! Lane of corner c (column + 2 row) of quad q (column + 4 row). */
__forceinline constexpr uint32_t laneOfCorner(uint32_t q, uint32_t c) {
  return laneOfVertex((q & 3) + (c & 1), (q >> 2) + (c >> 1));
}

struct alignas(64) VertTables {
  static const int lanes = 32; //!< 25 vertices, rounded up to two vectors of 16

  /*! Weights of the upper corner in a vertex's prediction (cellWeight), 0 to 1: [0: a block's first cell, 1: a
   *  group's cell][quads along the side, minus 1][lane]. */
  float weightX[2][16][lanes];
  float weightY[2][16][lanes];

  int32_t field[lanes];     //!< index of the vertex's field; 0 without one, as for corners
  int32_t hasField[lanes];  //!< mask: -1 with a field, otherwise 0
  uint8_t laneOfField[24];  //!< inverse of `field`
  uint8_t corners[16][4];   //!< laneOfCorner(quad,corner)
  uint8_t triangles[32][4]; //!< lanes of the vertices of a triangle (cornerOfTriangle); the fourth is unused

  /*! Loads and shuffles that extract the fields of a cell, for one number of bits. A window is 16 bytes with the
   *  fields of a row's first four columns; a byte shuffle moves each field to its lane. */
  struct Windows {
    static const int rows = 5;
    alignas(16) uint8_t shuffle[rows][16];          //!< moves 4 bytes to each lane, from the field's first byte on
    alignas(16) uint8_t shuffleFifthByte[rows][16]; //!< moves the fifth byte of fields that have one
    alignas(32) int32_t shift[4 * rows];            //!< first bit of the field in its byte
    alignas(16) int32_t factor[4 * rows];           //!< moves the first bit to bit 7, as SSE has no shifts per lane
    uint8_t offset[rows];                           //!< of the window, in bytes from the first field
    /*! Byte and bit at which the field in the row's fifth column starts. Unused in the first and last row, where
     *  it is a corner. */
    uint8_t columnOffset[rows], columnShift[rows];
  };

  static const int maxWindowBits = 32;
  static const int maxFourByteBits = 25; //!< largest field that fits into four bytes from each first bit, 0 to 7
  static const int maxOverread = 8;      //!< bytes that windows may read after the last field

  /*! False for fields below 3 bits, whose windows would read too far, and of 31 bits: four can extend over 17
   *  bytes. */
  static __forceinline bool hasWindows(int bits) { return bits >= 3 && bits != 31; }

  Windows windows[maxWindowBits + 1];

  VertTables();

private:
  void setWindows(int bits);
};

extern const VertTables vertTables;
} // namespace embree::cbvh
