// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A cell of cVERT: up to 5 x 5 vertices with integer coordinates. Its four corners are the block's, or vertices of the
 * first cell. The other 21 are predicted by bilinear interpolation, and a bit field stores the residual of each:
 *
 *     c01--18--19--20--c11      The first cell of a block has the corners of 4 x 4 groups. The cell
 *      13  14  15  16  17       of a group has the vertices of its 4 x 4 quads. If a block ends
 *       8   9  10  11  12       before a group does, all following columns (rows) equal the last
 *       3   4   5   6   7       one: their quads have no area and are never hit.
 *     c00---0---1---2--c10
 *
 * Displacement follows a normal, so the three components of a residual are nearly proportional. The component on the
 * cell's main axis is stored as is, the other two minus a slope times the main one. Coordinates are less than
 * maxExtent, so all arithmetic is exact, in integers or floats, fused or not, on every ISA and GPU.
 *
 * Word of a cell:
 *
 *   bits  0..3, 4..7, 8..11   bits of a residual along the main axis and the next two axes
 *   bits 12..13               main axis
 *   bits 14..18, 19..23       slopes of the next two axes, signed, in 1/16
 *
 * A field holds the three residuals in two's complement, the main one in the lowest bits. Field f starts at bit f*b,
 * where b is the sum of the three numbers of bits. If b exceeds 32, the residuals are stored as three arrays instead,
 * one per axis, main axis first. */

#ifndef CVERT_FORMAT_CELL_H
#define CVERT_FORMAT_CELL_H

#include "../portable/language.h"

CVERT_BEGIN

CVERT_CONSTANT int cellVertices = 25;    //!< stored row by row
CVERT_CONSTANT int cellFields = 21;      //!< all but the corners
CVERT_CONSTANT int maxFieldBits = 32;    //!< of a field with all three residuals
CVERT_CONSTANT int maxResidualBits = 15; //!< per axis
CVERT_CONSTANT int maxSlope = 15;        //!< in 1/16

/*! Exclusive bound of coordinates. Terms of predictions then have at most 16 bits before the binary point and 8 after
 *  it, exact in float. */
CVERT_CONSTANT int maxExtent = 16384;

/*! Bits of component i of a residual: 0 is on the main axis, 1 and 2 are on the next two. */
CVERT_FUNCTION int cellBits(uint32_t word, int i) { return int((word >> (4 * i)) & 15u); }
CVERT_FUNCTION int cellFieldBits(uint32_t word) { return cellBits(word, 0) + cellBits(word, 1) + cellBits(word, 2); }
CVERT_FUNCTION int cellMainAxis(uint32_t word) { return int((word >> 12) & 3u); }

/*! Returns (axis + i) modulo 3, for i from 0 to 2. A table with 2 bits per entry, because a branch would be
 *  mispredicted. Axis 3, in damaged blocks, counts as 0. */
CVERT_FUNCTION int axisAfter(int axis, int i) { return int((0x924u >> (2 * (axis + i))) & 3u); }

CVERT_FUNCTION int cellAxis(uint32_t word, int i) { return axisAfter(cellMainAxis(word), i); }

/*! Slope of component i (1 or 2), in 1/16. */
CVERT_FUNCTION int cellSlope(uint32_t word, int i) { return int(word << (18 - 5 * i)) >> 27; }

CVERT_FUNCTION uint32_t cellBytes(uint32_t word) { return (uint32_t(cellFields * cellFieldBits(word)) + 7u) / 8u; }

/*! Returns the field of vertex i of row j, or -1 for a corner. */
CVERT_FUNCTION int cellField(int i, int j) {
  bool corner = (i == 0 || i == 4) && (j == 0 || j == 4);
  return corner ? -1 : 5 * j + i - (j == 0 ? 1 : j == 4 ? 3 : 2);
}

/*! Weight, in 1/16, of the upper corner in the prediction of vertex i, which is step*i quads from the lower corner.
 *  quads: number of the cell's quads in this direction. */
CVERT_FUNCTION int cellWeight(int i, int step, int quads) {
  int x = step * i;
  if (x > quads) x = quads;
  return (32 * x + quads) / (2 * quads);
}

/*! True if residuals are stored as three arrays. */
CVERT_FUNCTION bool isByAxis(uint32_t word) { return cellFieldBits(word) > maxFieldBits; }

/*! Decodes a component of a residual: `bits` bits of a field, from bit `shift` on. */
CVERT_FUNCTION int cellResidual(uint32_t field, int shift, int bits) {
  if (bits == 0) return 0;
  uint32_t value = (field >> shift) & ((1u << bits) - 1u);
  return (value >> (bits - 1)) != 0u ? int(value) - int(1u << bits) : int(value);
}

/*! Part of a component that its slope predicts. main: component on the main axis. Rounds to nearest, halves up. */
CVERT_FUNCTION int slopeResidual(int slope, int main) { return (slope * main + 8) >> 4; }

/*! Bilinear prediction from the corners' coordinates. weightX, weightY: cellWeight. Rounds to nearest, halves up. */
CVERT_FUNCTION int cellPrediction(int c00, int c10, int c01, int c11, int weightX, int weightY) {
  int sum = 16 * weightX * (c10 - c00) + 16 * weightY * (c01 - c00) + weightX * weightY * (c11 - c10 - c01 + c00);
  return c00 + ((sum + 128) >> 8);
}

CVERT_END

#endif
