// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Blocks of a mesh of quads, or of triangles of which two make a quad: each quad is a primitive of its own, with its own
 * parameters, and a block says which by a pattern, where there is one:
 *
 *   rows        numbers grow by a step along x and by another along y: a sheet that was written row by row
 *   recursive   bits of x and y exchange bits of the number: quads that were cut into four, and those again
 *   table       any other order of quads; bits for each quad: its number minus the lowest
 *   triangles   any order of triangles; bits for each triangle: its number minus the lowest, and its turn
 *
 * Bit 30 of boxForm says that a block is one of these. It has VertNumbers behind its header, where others have edges; patchQuads
 * is the form of its numbers, and primID the number that they count from.
 *
 * The number of a quad of two triangles is that of its first triangle. The second has a number that is a distance
 * higher: 1, or what the block stores as VertHalves, so that an application may list all first triangles before all
 * second ones. A triangle's parameters depend on which of its corners the application begins with: forms hold that, or
 * the table of triangles. block.h reads all of it. */

#ifndef CVERT_QUAD_NUMBERS_H
#define CVERT_QUAD_NUMBERS_H

#include "../basics/bytes.h"

CVERT_BEGIN

struct VertNumbers
{
  /* rows: steps; recursive: 8 bits for each bit of x and y; tables: offset from the block's start, bits per quad or
   * triangle. With VertHalves, x is their offset from the block's start, and y is 0. */
  uint32_t x, y;
};
CVERT_READABLE(VertNumbers,4)

/*! Of a block whose second triangles do not follow the first ones: after all else but a table. */
struct VertHalves
{
  VertNumbers numbers;
  uint32_t distance; //!< from the number of a first triangle to that of the second, modulo 2^32
};
CVERT_READABLE(VertHalves,4)

CVERT_FUNCTION bool hasNumbers (uint32_t boxForm) { return ((boxForm >> 30) & 1u) != 0u; }

/* Forms: bits 0..1 the pattern, 2 triangles, 3 a triangle that has no second, 4..5 and 6..7 the turns of the first and the second
 * triangle, 8..15 of recursive numbers what they begin with, 16 VertHalves. */
CVERT_CONSTANT uint32_t numbersInRows = 0u;
CVERT_CONSTANT uint32_t numbersRecursive = 1u;
CVERT_CONSTANT uint32_t numbersInTable = 2u;
CVERT_CONSTANT uint32_t numbersInTriangleTable = 3u;
CVERT_CONSTANT uint32_t numbersOfTriangles = 4u;
CVERT_CONSTANT uint32_t numbersOfOneTriangle = 8u;
CVERT_CONSTANT uint32_t numbersOfHalves = 1u << 16;

CVERT_FUNCTION uint32_t patternOfNumbers (uint32_t form) { return form & 3u; }
CVERT_FUNCTION bool haveTable (uint32_t form) { return patternOfNumbers(form) >= numbersInTable; }
CVERT_FUNCTION bool haveHalves (uint32_t form) { return (form & numbersOfHalves) != 0u; }
CVERT_FUNCTION bool isOfTriangles (uint32_t form) { return (form & numbersOfTriangles) != 0u; }
CVERT_FUNCTION bool isOneTriangle (uint32_t form) { return (form & numbersOfOneTriangle) != 0u; }
CVERT_FUNCTION uint32_t formOfTurns (uint32_t first, uint32_t second) { return (first << 4) | (second << 6); }
CVERT_FUNCTION uint32_t turnOfTriangle (uint32_t form, bool isSecond) { return (form >> (isSecond ? 6 : 4)) & 3u; }

/*! of quad x, y of a block, whose numbers are no table, from the first */
CVERT_FUNCTION uint32_t patternNumber (uint32_t form, VertNumbers numbers, uint32_t x, uint32_t y)
{
  if (patternOfNumbers(form) == numbersInRows) return numbers.x*x + numbers.y*y;
  uint32_t code = (form >> 8) & 255u;
  for (uint32_t i=0u; i<4u; i++) {
    if (((x >> i) & 1u) != 0u) code ^= (numbers.x >> (8u*i)) & 255u;
    if (((y >> i) & 1u) != 0u) code ^= (numbers.y >> (8u*i)) & 255u;
  }
  return isOfTriangles(form) && !haveHalves(form) ? 2u*code : code;
}

/*! An entry of a table of triangles has the turn in its lowest bits, so these numbers are within 2^30 of the lowest. */
CVERT_CONSTANT uint32_t turnBits = 2u;

/*! entries of a table */
CVERT_FUNCTION uint32_t entriesPerQuad (uint32_t form) {
  return patternOfNumbers(form) == numbersInTriangleTable ? 2u : 1u;
}

/*! bytes of a table, which has 32 bits behind its last that may be read */
CVERT_FUNCTION uint32_t bytesOfNumberTable (uint32_t entries, uint32_t bits) { return (entries*bits + 7u)/8u; }

/*! A primitive at a quad: the quad, or one of its triangles. */
struct QuadPrimitive
{
  uint32_t primID;
  uint32_t form; //!< of its block, with the turn of this triangle: for ownParameters() and turnOfTriangle()
};

/*! Parameters of the primitive at position a, b of a quad, from 0 to 1. */
struct OwnParameters { float u, v; };

CVERT_FUNCTION OwnParameters ownParameters (uint32_t form, bool isSecond, float a, float b)
{
  OwnParameters parameters;
  parameters.u = a;
  parameters.v = b;
  if (!isOfTriangles(form)) return parameters;
  /* weights of the corners 00, 10, 01, or 11, 01, 10 */
  float w1 = isSecond ? 1.0f-a : a, w2 = isSecond ? 1.0f-b : b;
  float w0 = greater(1.0f-w1-w2,0.0f);
  uint32_t turn = turnOfTriangle(form,isSecond);
  parameters.u = turn == 0u ? w1 : turn == 1u ? w2 : w0;
  parameters.v = turn == 0u ? w2 : turn == 1u ? w0 : w1;
  return parameters;
}

CVERT_END

#endif
