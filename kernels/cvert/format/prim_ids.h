// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Primitive numbers (primIDs) of blocks of a quad mesh, or of a triangle mesh whose pairs of triangles form quads. Each
 * quad or triangle of the mesh is a primitive with its own parameters u and v. docs/formats/mesh.md specifies
 * the format. Patterns:
 *
 *   rows        numbers grow by a step along x and by another along y: sheets that were written row by row
 *   recursive   bits of x and y map to bits of the number: quads that were split into four recursively
 *   table       any order of quads; per quad: its number minus the lowest
 *   triangles   any order of triangles; per triangle: its number minus the lowest, and its first corner
 *
 * Bit 30 of VertHeader::info marks such blocks. VertPrimIDs follows the header in place of edges. patchQuads is the
 * numbering, a word with the pattern and its settings, and primID the base of the numbers.
 *
 * Except in a table of triangles, the number of a quad of two triangles is the number of its first triangle. The second
 * triangle's number is higher by 1 or, if the block has VertTrianglePairs, by its distance. The first corner of the
 * application's triangle, stored in the numbering or the table, determines its parameters. */

#ifndef CVERT_FORMAT_PRIM_IDS_H
#define CVERT_FORMAT_PRIM_IDS_H

#include "../portable/bytes.h"

CVERT_BEGIN

struct VertPrimIDs {
  /* rows: differences between neighboring quads along x and y. recursive: 8 bits for each bit of x and y. tables: byte
   * offset from the start of the block, and bits per entry. If the block has VertTrianglePairs, x and y after the
   * header are its byte offset and 0. */
  uint32_t x, y;
};
CVERT_READABLE(VertPrimIDs, 4)

/*! Section of blocks whose second triangles all have the same distance, not 1. Precedes the table, if any. */
struct VertTrianglePairs {
  VertPrimIDs numbers;
  uint32_t distance; //!< second triangle's number minus first triangle's, modulo 2^32
};
CVERT_READABLE(VertTrianglePairs, 4)

CVERT_FUNCTION bool hasPrimIDs(uint32_t info) { return ((info >> 30) & 1u) != 0u; }

/* Numbering: bits 0..1: pattern; 2: triangles; 3: single triangles; 4..5, 6..7: first corner of the first and of the
 * second triangle; 8..15: initial value of recursive numbers; 16: has VertTrianglePairs. */
CVERT_CONSTANT uint32_t primIDsInRows = 0u;
CVERT_CONSTANT uint32_t primIDsRecursive = 1u;
CVERT_CONSTANT uint32_t primIDsInTable = 2u;
CVERT_CONSTANT uint32_t primIDsInTriangleTable = 3u;
CVERT_CONSTANT uint32_t primIDsOfTriangles = 4u;
CVERT_CONSTANT uint32_t primIDsOfOneTriangle = 8u;
CVERT_CONSTANT uint32_t primIDsOfTrianglePairs = 1u << 16;

CVERT_FUNCTION uint32_t patternOfPrimIDs(uint32_t numbering) { return numbering & 3u; }
CVERT_FUNCTION bool haveTable(uint32_t numbering) { return patternOfPrimIDs(numbering) >= primIDsInTable; }
CVERT_FUNCTION bool haveTrianglePairs(uint32_t numbering) { return (numbering & primIDsOfTrianglePairs) != 0u; }
CVERT_FUNCTION bool isTriangleNumbering(uint32_t numbering) { return (numbering & primIDsOfTriangles) != 0u; }
CVERT_FUNCTION bool isSingleTriangleNumbering(uint32_t numbering) { return (numbering & primIDsOfOneTriangle) != 0u; }
CVERT_FUNCTION uint32_t packFirstCorners(uint32_t first, uint32_t second) { return (first << 4) | (second << 6); }
CVERT_FUNCTION uint32_t firstCornerOfTriangle(uint32_t numbering, bool isSecond) {
  return (numbering >> (isSecond ? 6 : 4)) & 3u;
}

/*! Number of quad x, y, minus VertHeader::primID. Requires a numbering without table. */
CVERT_FUNCTION uint32_t patternNumber(uint32_t numbering, VertPrimIDs numbers, uint32_t x, uint32_t y) {
  if (patternOfPrimIDs(numbering) == primIDsInRows) return numbers.x * x + numbers.y * y;
  uint32_t code = (numbering >> 8) & 255u;
  for (uint32_t i = 0u; i < 4u; i++) {
    if (((x >> i) & 1u) != 0u) code ^= (numbers.x >> (8u * i)) & 255u;
    if (((y >> i) & 1u) != 0u) code ^= (numbers.y >> (8u * i)) & 255u;
  }
  return isTriangleNumbering(numbering) && !haveTrianglePairs(numbering) ? 2u * code : code;
}

/*! Number of lowest bits of a triangle table's entry that store the first corner. 30 remain for the number. */
CVERT_CONSTANT uint32_t firstCornerBits = 2u;

CVERT_FUNCTION uint32_t entriesPerQuad(uint32_t numbering) {
  return patternOfPrimIDs(numbering) == primIDsInTriangleTable ? 2u : 1u;
}

/*! Size of a table without padding. Readers may read up to 7 bytes after its end. */
CVERT_FUNCTION uint32_t bytesOfNumberTable(uint32_t entries, uint32_t bits) { return (entries * bits + 7u) / 8u; }

/*! Primitive that a hit in a quad reports: the quad, or one of its triangles. */
struct QuadPrimitive {
  uint32_t primID;
  uint32_t numbering; //!< of its block, with this triangle's first corner
};

struct PrimitiveParameters {
  float u, v;
};

/*! Converts position a, b in a quad to parameters of the application's quad or triangle. numbering:
 *  QuadPrimitive::numbering. */
CVERT_FUNCTION PrimitiveParameters primitiveParameters(uint32_t numbering, bool isSecond, float a, float b) {
  PrimitiveParameters parameters;
  parameters.u = a;
  parameters.v = b;
  if (!isTriangleNumbering(numbering)) return parameters;
  // w0, w1, w2: weights of corners 00, 10, 01, or 11, 01, 10 in the second triangle
  float w1 = isSecond ? 1.0f - a : a, w2 = isSecond ? 1.0f - b : b;
  float w0 = maximum(1.0f - w1 - w2, 0.0f);
  uint32_t firstCorner = firstCornerOfTriangle(numbering, isSecond);
  parameters.u = firstCorner == 0u ? w1 : firstCorner == 1u ? w2 : w0;
  parameters.v = firstCorner == 0u ? w2 : firstCorner == 1u ? w0 : w1;
  return parameters;
}

CVERT_END

#endif
