// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A cell of cVERT: up to 5 x 5 vertices on a lattice of integers. Its four corners are known
 * from above; the other 21 are predicted from them, bilinearly, and what is missing of each
 * is a field of bits:
 *
 *     c01--18--19--20--c11      A cell of the block's first level has the corners of 4 x 4
 *      13  14  15  16  17       groups, those of a group are the vertices of its 4 x 4 quads.
 *       8   9  10  11  12       Where a block ends before a group does, the last column (row)
 *       3   4   5   6   7       stands for all that would come after it: quads there have no
 *     c00---0---1---2--c10      area and are never hit.
 *
 * Displacement goes along a normal, so the three components of a residual are nearly
 * proportional. Only that of the cell's main axis is stored whole; the other two are
 * stored less a slope times the first. All of this is exact: in integers or in floats of 24
 * bits, fused or not, on every ISA and GPU it gives the same vertex, as extents are at most
 * maxExtent.
 *
 * A cell has a word:
 *
 *   bits  0..3, 4..7, 8..11   bits of a residual along the main axis and the next two
 *   bits 12..13               main axis
 *   bits 14..18, 19..23       slopes of the next two axes, signed, in 1/16
 *
 * A field holds the three residuals, the main one lowest, each in two's complement. Field f
 * starts at bit f times the sum of the three numbers. Where that is more than 32 the residuals
 * of all fields along the main axis come first, then those along the next, then the last. */

#ifndef CVERT_VERTEX_CELL_H
#define CVERT_VERTEX_CELL_H

#include "../basics/language.h"

CVERT_BEGIN

CVERT_CONSTANT int cellVertices = 25; //!< row by row
CVERT_CONSTANT int cellFields = 21;   //!< all but the corners
CVERT_CONSTANT int maxFieldBits = 32; //!< of a field that holds all three residuals
CVERT_CONSTANT int maxResidualBits = 15;
CVERT_CONSTANT int maxSlope = 15;

/*! Coordinates in a block are less than this: then a prediction has 16 bits before the point
 *  and 8 behind it, which a float holds. */
CVERT_CONSTANT int maxExtent = 16384;

CVERT_FUNCTION int cellBits (uint32_t word, int i) { return int((word >> (4*i)) & 15u); }
CVERT_FUNCTION int cellFieldBits (uint32_t word) { return cellBits(word,0) + cellBits(word,1) + cellBits(word,2); }
CVERT_FUNCTION int cellMainAxis (uint32_t word) { return int((word >> 12) & 3u); }

/*! The axis that comes i after another, counted round, i up to 2: by a table of two bits each, as a processor
 *  would not foresee a branch. 3 counts as 0. */
CVERT_FUNCTION int axisAfter (int axis, int i) { return int((0x924u >> (2*(axis + i))) & 3u); }

/*! axis of component i of a residual */
CVERT_FUNCTION int cellAxis (uint32_t word, int i) { return axisAfter(cellMainAxis(word),i); }

/*! of component 1 or 2, in 1/16 */
CVERT_FUNCTION int cellSlope (uint32_t word, int i) { return int(word << (18-5*i)) >> 27; }

/*! of all fields */
CVERT_FUNCTION uint32_t cellBytes (uint32_t word) { return (uint32_t(cellFields*cellFieldBits(word)) + 7u)/8u; }

/*! field of vertex i, j; -1 for a corner */
CVERT_FUNCTION int cellField (int i, int j)
{
  bool corner = (i == 0 || i == 4) && (j == 0 || j == 4);
  return corner ? -1 : 5*j + i - (j == 0 ? 1 : j == 4 ? 3 : 2);
}

/*! The weight of the upper corner in a prediction, in 1/16, for vertex i of 5: it is step*i
 *  quads from the lower one, and the cell has quads of them. */
CVERT_FUNCTION int cellWeight (int i, int step, int quads)
{
  int x = step*i;
  if (x > quads) x = quads;
  return (32*x + quads)/(2*quads);
}

/*! whether residuals come axis by axis */
CVERT_FUNCTION bool isByAxis (uint32_t word) { return cellFieldBits(word) > maxFieldBits; }

/*! component of a residual before slopes: `bits` of a field from bit `shift` on */
CVERT_FUNCTION int cellResidual (uint32_t field, int shift, int bits)
{
  if (bits == 0) return 0;
  uint32_t value = (field >> shift) & ((1u << bits) - 1u);
  return (value >> (bits-1)) != 0u ? int(value) - int(1u << bits) : int(value);
}

/*! what a slope adds, from the residual along the main axis: rounded to the nearest, up where
 *  two are near */
CVERT_FUNCTION int slopeResidual (int slope, int main) { return (slope*main + 8) >> 4; }

/*! bilinear prediction of a coordinate, rounded likewise */
CVERT_FUNCTION int cellPrediction (int c00, int c10, int c01, int c11, int weightX, int weightY)
{
  int sum = 16*weightX*(c10-c00) + 16*weightY*(c01-c00) + weightX*weightY*(c11-c10-c01+c00);
  return c00 + ((sum + 128) >> 8);
}

CVERT_END

#endif
