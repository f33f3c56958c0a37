// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A cVERT block: up to 16 x 16 quads of a patch, in up to 4 x 4 groups of 4 x 4 quads. A patch is a face of a cage, a
 * part of such a face, a grid, or a rectangle of a mesh's quads. docs/formats/block.md specifies the format. Layout:
 *
 *   header | edges of the patch, or primitive numbers of quads | word of remainders | margins of groups |
 *   words of groups | fields of the first cell | fields of groups | remainders | table of primitive numbers
 *
 * motion.h adds the parts of moving blocks.
 *
 * On each axis a vertex is
 *
 *   origin + coordinate * spacing + remainder * spacing / 2^bits,
 *
 * with a power of two as spacing. Coordinates have 14 bits, coded in cells (cell.h). If vertices need more bits, the
 * lower ones are stored as remainders, or the vertices as floats on an axis that needs too many. Vertices are exact in
 * float, fused or not: the origin and the sum before the remainder are multiples of the spacing. Blocks therefore share
 * vertices exactly, which keeps surfaces watertight.
 *
 * A group's box is the box of its four corners, which are vertices of the first cell, enlarged by margins of 4 bits per
 * side. On one axis it bounds a sheared coordinate, so that inclined sheets have flat boxes.
 *
 * A raw block stores vertices and boxes as floats, if a vertex is not finite or floats need fewer bytes. */

#ifndef CVERT_FORMAT_BLOCK_H
#define CVERT_FORMAT_BLOCK_H

#include "../portable/bytes.h"
#include "cell.h"
#include "limits.h"
#include "prim_ids.h"

CVERT_BEGIN

/*! Changes that affect readers increment it. */
CVERT_CONSTANT uint32_t vertFormatVersion = 5u;

/*! Decoders will always read versions from this one on. */
CVERT_CONSTANT uint32_t oldestVertVersion = 5u;

/*! Decoders may read this many bytes after a block. Owners of blocks must keep them readable. */
CVERT_CONSTANT uint32_t vertReadPadding = 16u;

CVERT_CONSTANT uint32_t groupQuads = 4u;      //!< quads per side of a group
CVERT_CONSTANT uint32_t maxVertLevel = 4u;    //!< at most 2^maxVertLevel quads per side
CVERT_CONSTANT uint32_t vertBlockQuads = 16u; //!< blocks begin at multiples of this in their patch
/*! Blocks along a side of a patch with `quads` quads. */
CVERT_FUNCTION uint32_t vertBlocksAlong(uint32_t quads) { return (quads + vertBlockQuads - 1u) / vertBlockQuads; }
CVERT_CONSTANT uint32_t maxVertGroups = 16u;
CVERT_CONSTANT uint32_t vertHeaderBytes = 64u;
CVERT_CONSTANT uint32_t vertCornersOffset = 32u; //!< offset of corners in the header
CVERT_CONSTANT uint32_t vertEdgesBytes = 8u;
CVERT_CONSTANT uint32_t vertMotionBytes = 16u;
CVERT_CONSTANT uint32_t vertRemaindersBytes = 4u;
CVERT_CONSTANT uint32_t maxRemainderBits = 24u;    //!< per axis; the precision of a float
CVERT_CONSTANT uint32_t remaindersAreFloats = 31u; //!< special value for a number of bits
CVERT_CONSTANT uint32_t maxMargin = 15u;           //!< largest margin in steps, see marginShift
CVERT_CONSTANT uint32_t boxPlanes = 6u;            //!< per group of a raw block: lower x, y, z, then upper x, y, z

struct VertHeader {
  float origin[3];     //!< position of coordinates (0,0,0)
  uint32_t bounds;     //!< bounds of the block, 8 bits each: see boundsUnit
  uint32_t surface;    //!< surface number, see limits.h
  uint32_t primID;     //!< primitive of the patch, or base of the quads' primitive numbers (prim_ids.h)
  uint32_t region;     //!< size and position in the patch: see packRegion
  uint32_t patchQuads; //!< quads of the patch: see packPatchQuads; or numbering (prim_ids.h)
  uint32_t corners[6]; //!< coordinates of corners 00, 10, 01 and 11: x, y, z of 00 first. 14 of 16 bits each; see
                       //!< cornerBits for the other 2
  uint32_t info;       //!< bits 0..11: shifts of margins; 12..13: sheared axis, or 3: raw; 14..23: shear of boxes;
                       //!< 24: has remainders; 25..28: shift of bounds; 29: has edges; 30: has primitive numbers;
                       //!< 31: moves
  uint32_t word;       //!< word of the first cell; bits 24..31: exponent of the spacing on x
};
CVERT_READABLE(VertHeader, 16)

/*! quadsX, quadsY: size of the block, 1 to 16. x, y: its first quad in the patch, multiples of vertBlockQuads. */
CVERT_FUNCTION uint32_t packRegion(uint32_t quadsX, uint32_t quadsY, uint32_t x, uint32_t y) {
  return (quadsX - 1u) | ((quadsY - 1u) << 4) | ((x / vertBlockQuads) << 8) | ((y / vertBlockQuads) << 20);
}
CVERT_FUNCTION uint32_t vertQuadsX(uint32_t region) { return (region & 15u) + 1u; }
CVERT_FUNCTION uint32_t vertQuadsY(uint32_t region) { return ((region >> 4) & 15u) + 1u; }
CVERT_FUNCTION uint32_t vertFirstX(uint32_t region) { return ((region >> 8) & 4095u) * vertBlockQuads; }
CVERT_FUNCTION uint32_t vertFirstY(uint32_t region) { return (region >> 20) * vertBlockQuads; }

CVERT_FUNCTION uint32_t packPatchQuads(uint32_t quadsX, uint32_t quadsY) {
  return (quadsX - 1u) | ((quadsY - 1u) << 16);
}
CVERT_FUNCTION uint32_t patchQuadsX(uint32_t patchQuads) { return (patchQuads & 65535u) + 1u; }
CVERT_FUNCTION uint32_t patchQuadsY(uint32_t patchQuads) { return (patchQuads >> 16) + 1u; }

/*! Edges of a patch: 16 bits for each of v = 0, u = 1, v = 1 and u = 0. The lower 12 bits are the edge's rate minus 1;
 *  the rate is at most the patch's quads along the edge. The upper 4 bits of the first two are the face parameters u
 *  and v at the patch's corner, in halves; in the last two they are 0, reserved. Follows the header if the patch does
 *  not begin at its face's corner, or if the block touches an edge of a lower rate. */
struct VertEdges {
  uint32_t low, high; //!< edges v = 0 and u = 1, edges v = 1 and u = 0
};
CVERT_READABLE(VertEdges, 4)

CVERT_FUNCTION bool hasEdges(uint32_t info) { return ((info >> 29) & 1u) != 0u; }

CVERT_FUNCTION VertEdges packEdges(uint32_t rate0, uint32_t rate1, uint32_t rate2, uint32_t rate3, uint32_t cornerU,
                                   uint32_t cornerV) {
  VertEdges edges;
  edges.low = (rate0 - 1u) | (cornerU << 12) | ((rate1 - 1u) << 16) | (cornerV << 28);
  edges.high = (rate2 - 1u) | ((rate3 - 1u) << 16);
  return edges;
}
CVERT_FUNCTION uint32_t vertRate(VertEdges edges, int edge) {
  return (((edge < 2 ? edges.low : edges.high) >> (16 * (edge & 1))) & 4095u) + 1u;
}
CVERT_FUNCTION uint32_t vertCornerU(VertEdges edges) { return (edges.low >> 12) & 15u; }
CVERT_FUNCTION uint32_t vertCornerV(VertEdges edges) { return edges.low >> 28; }

/*! Follows the header of a moving block, and VertEdges or VertPrimIDs if present. */
struct VertMotion {
  float begin, end;  //!< times of the first and last step
  uint32_t numSteps; //!< at least 2
  uint32_t steps;    //!< offset of the 4-byte offsets of the steps after the first, from the start of the block
};
CVERT_READABLE(VertMotion, 4)

CVERT_FUNCTION bool isMoving(uint32_t info) { return (info >> 31) != 0u; }

/*! Byte offset of VertMotion. */
CVERT_FUNCTION uint32_t motionOffset(uint32_t info) {
  return vertHeaderBytes + (hasEdges(info) || hasPrimIDs(info) ? vertEdgesBytes : 0u);
}

/*! Groups along a side of a block with `quads` quads. */
CVERT_FUNCTION uint32_t groupsOf(uint32_t quads) { return (quads + groupQuads - 1u) / groupQuads; }

/*! Quads along a side of group g. quads: along the same side of the block. */
CVERT_FUNCTION uint32_t quadsOfGroup(uint32_t quads, uint32_t g) {
  uint32_t rest = quads - groupQuads * g;
  return rest < groupQuads ? rest : groupQuads;
}

/* On the sheared axis, m, boxes bound
 *
 *   h = d[m] + (s1 d[m+1] + s2 d[m+2])/16,    axes modulo 3,
 *
 * where d is coordinate * spacing. VertHeader::info stores m and the slopes in the same bits as a cell's word stores
 * main axis and slopes: the accessors of cell.h apply to both. */

/*! Margins on an axis are multiples of 2^marginShift coordinates. */
CVERT_FUNCTION uint32_t marginShift(uint32_t info, int axis) { return (info >> (4 * axis)) & 15u; }

CVERT_FUNCTION int shearedAxis(uint32_t info) { return cellAxis(info, 0); }

/*! Slope s1 or s2 (i = 1 or 2), in 1/16. */
CVERT_FUNCTION int shearSlope(uint32_t info, int i) { return cellSlope(info, i); }

/*! Unit of VertHeader::bounds, in coordinates. Bits 0..7 and 8..15 are the upper bounds on the axes m+1 and m+2,
 *  whose lower bounds are 0. Bits 16..23 and 24..31, signed, are the lower and the upper bound of the sheared
 *  coordinate. */
CVERT_FUNCTION uint32_t boundsUnit(uint32_t info) { return 1u << ((info >> 25) & 15u); }

/*! Byte i of VertHeader::bounds, in units of boundsUnit. */
CVERT_FUNCTION int encodedBound(uint32_t bounds, int i) {
  int bits = int((bounds >> (8 * i)) & 255u);
  return i >= 2 && bits >= 128 ? bits - 256 : bits;
}

CVERT_CONSTANT uint32_t rawInfo = 3u << 12; //!< bits of VertHeader::info in a raw block
CVERT_FUNCTION bool isRaw(uint32_t info) { return ((info >> 12) & 3u) == 3u; }

/* Coordinates leave two bits free in each of the 12 values of corners. For value i, in order of corners:
 *
 *   i = 0 to 7    bit 15: bit i of the exponent of the spacing on y, bit 14: bit i of the exponent on z
 *   i = 8 to 11   bit 15: bit i-8 of the version of the block's format, bit 14: reserved, 0 */

/*! Returns bit `at` (14 or 15) of both values in a word of corners, of the lower value in bit 0. */
CVERT_FUNCTION uint32_t cornerBits(uint32_t pair, uint32_t at) {
  return ((pair >> at) & 1u) | ((pair >> (at + 15u)) & 2u);
}

/*! The same for the 8 values in four words. */
CVERT_FUNCTION uint32_t cornerBits(uint32_t c0, uint32_t c1, uint32_t c2, uint32_t c3, uint32_t at) {
  return cornerBits(c0, at) | cornerBits(c1, at) << 2 | cornerBits(c2, at) << 4 | cornerBits(c3, at) << 6;
}

/*! c4, c5: the last two words of corners. Later steps of moving blocks have version 0. */
CVERT_FUNCTION uint32_t versionOfCorners(uint32_t c4, uint32_t c5) {
  return cornerBits(c4, 15u) | cornerBits(c5, 15u) << 2;
}
CVERT_FUNCTION uint32_t reservedOfCorners(uint32_t c4, uint32_t c5) {
  return cornerBits(c4, 14u) | cornerBits(c5, 14u) << 2;
}

/*! Spacings on x, y and z: powers of two, stored as biased exponents of floats. */
struct VertSpacing {
  float at[3];
};

/*! word: of the first cell. c0 to c3: the first four words of corners. */
CVERT_FUNCTION VertSpacing vertSpacing(uint32_t word, uint32_t c0, uint32_t c1, uint32_t c2, uint32_t c3) {
  VertSpacing spacing;
  spacing.at[0] = floatOfBits((word >> 24) << 23);
  spacing.at[1] = floatOfBits(cornerBits(c0, c1, c2, c3, 15u) << 23);
  spacing.at[2] = floatOfBits(cornerBits(c0, c1, c2, c3, 14u) << 23);
  return spacing;
}

/*! Bounds of a block relative to its origin, in world units: 0 to upper[i] on the axes m+1 and m+2, sheared[0] to
 *  sheared[1] for the sheared coordinate. */
struct ShearedBounds {
  float upper[2], sheared[2];
};

/*! encoded: VertHeader::bounds, VertStep::bounds or VertStep::endBounds. unit: of `encoded`. The products are exact. */
CVERT_FUNCTION ShearedBounds decodeBounds(uint32_t info, uint32_t encoded, uint32_t unit, VertSpacing spacing) {
  int m = shearedAxis(info);
  ShearedBounds bounds;
  bounds.upper[0] = float(encodedBound(encoded, 0)) * float(unit) * spacing.at[axisAfter(m, 1)];
  bounds.upper[1] = float(encodedBound(encoded, 1)) * float(unit) * spacing.at[axisAfter(m, 2)];
  bounds.sheared[0] = float(encodedBound(encoded, 2)) * float(unit) * spacing.at[m];
  bounds.sheared[1] = float(encodedBound(encoded, 3)) * float(unit) * spacing.at[m];
  return bounds;
}

/*! Upper bound, on any axis, of the distance from the origin to vertices and planes of boxes. Slopes are less than 1,
 *  so no vertex is farther than the sum of the bounds; margins may double this. In a moving block, a plane may be even
 *  farther, but its distance from the vertices then exceeds its rounding error. One bound for all axes, because the
 *  shear of a ray mixes their rounding errors. */
CVERT_FUNCTION float extentOfBounds(ShearedBounds bounds) {
  return 2.0f * (maximum(-bounds.sheared[0], bounds.sheared[1]) + bounds.upper[0] + bounds.upper[1]);
}

CVERT_FUNCTION float vertExtent(uint32_t info, uint32_t encoded, uint32_t unit, VertSpacing spacing) {
  return extentOfBounds(decodeBounds(info, encoded, unit, spacing));
}

/*! Factor of the coordinate on axis m+i (i = 1 or 2) in h, which is in spacings of m. */
CVERT_FUNCTION float shearFactor(uint32_t info, int i, VertSpacing spacing) {
  int slope = shearSlope(info, i), m = shearedAxis(info);
  return slope == 0 ? 0.0f : float(slope) * (1.0f / 16.0f) * (spacing.at[axisAfter(m, i)] / spacing.at[m]);
}

/*! Word of group g's cell. words, wordsHigh: byte offsets of the words' lower 16 and upper 8 bits. storesUpperBits:
 *  false if the upper bits are 0 and not stored. */
CVERT_FUNCTION uint32_t wordOfGroup(CVERT_POINTER(void) data, uint32_t words, uint32_t wordsHigh, bool storesUpperBits,
                                    uint32_t g) {
  uint32_t low = uint16At(data, words + 2u * g);
  return storesUpperBits ? low | (byteAt(data, wordsHigh + g) << 16) : low;
}

/*! Byte offset after the fields of the first `groups` groups. cell, word: fields and word of the first cell. words: see
 *  wordOfGroup. */
CVERT_FUNCTION uint32_t endOfFields(CVERT_POINTER(void) data, uint32_t cell, uint32_t word, uint32_t words,
                                    uint32_t groups) {
  uint32_t end = cell + cellBytes(word);
  // the lower half of a word contains the numbers of bits
  for (uint32_t g = 0u; g < groups; g++) end += cellBytes(uint16At(data, words + 2u * g));
  return end;
}

/* Word of remainders:
 *
 *   bits 0..4, 5..9, 10..14    bits of a remainder on x, y and z, or remaindersAreFloats
 *   bit 15                     reserved, 0
 *   bits 16..31                offset of the remainders, in bytes from the start of the block or later step
 *
 * Remainders are stored row by row, x, y and z of each vertex, without gaps. */

CVERT_FUNCTION bool hasRemainders(uint32_t info) { return ((info >> 24) & 1u) != 0u; }
CVERT_FUNCTION uint32_t remainderBits(uint32_t remainders, int axis) { return (remainders >> (5 * axis)) & 31u; }
CVERT_FUNCTION uint32_t remainderOffset(uint32_t remainders) { return remainders >> 16; }

/*! Stored bits per vertex on an axis: of a remainder, or 32 of a float. */
CVERT_FUNCTION uint32_t storedRemainderBits(uint32_t remainders, int axis) {
  uint32_t bits = remainderBits(remainders, axis);
  return bits == remaindersAreFloats ? 32u : bits;
}

/*! Stored bits per vertex on all axes. */
CVERT_FUNCTION uint32_t remainderStride(uint32_t remainders) {
  return storedRemainderBits(remainders, 0) + storedRemainderBits(remainders, 1) + storedRemainderBits(remainders, 2);
}

/*! Offset of a remainder, in bits from the start of the block or later step. vertex: index, row by row. */
CVERT_FUNCTION uint32_t remainderBegin(uint32_t remainders, uint32_t vertex, int axis) {
  uint32_t bit = 8u * remainderOffset(remainders) + vertex * remainderStride(remainders);
  if (axis > 0) bit += storedRemainderBits(remainders, 0);
  if (axis > 1) bit += storedRemainderBits(remainders, 1);
  return bit;
}

CVERT_FUNCTION float remainderSpacing(float spacing, uint32_t bits) {
  return spacing * floatOfBits((127u - bits) << 23);
}

/*! Adds a remainder to a world coordinate, or returns the float that replaces both. word: the remainder, in the lowest
 *  bits. bits: remainderBits, not 0. */
CVERT_FUNCTION float addRemainder(float without, uint32_t word, uint32_t bits, float spacing) {
  if (bits == remaindersAreFloats) return floatOfBits(word);
  return without + float(word & ((1u << bits) - 1u)) * remainderSpacing(spacing, bits);
}

CVERT_FUNCTION uint32_t bytesOfRemainders(uint32_t remainders, uint32_t region) {
  return ((vertQuadsX(region) + 1u) * (vertQuadsY(region) + 1u) * remainderStride(remainders) + 7u) / 8u;
}

/* Distances, in coordinates, from the box of a group's corners to its box. margins: the group's byte for an axis.
 * shift: marginShift. */
CVERT_FUNCTION int lowerMargin(uint32_t margins, uint32_t shift) { return int((margins & 15u) << shift); }
CVERT_FUNCTION int upperMargin(uint32_t margins, uint32_t shift) { return int((margins >> 4) << shift); }

/* Corner c (column + 2 row) of the block. pair: word cornerPair(c,axis) of corners. */
CVERT_FUNCTION int cornerPair(int c, int axis) { return (3 * c + axis) >> 1; }
CVERT_FUNCTION int cornerCoordinate(uint32_t pair, int c, int axis) {
  return int((pair >> (16 * ((3 * c + axis) & 1))) & 16383u);
}

/*! Offsets of sections, in bytes from the start of the block. Groups are stored row by row. */
struct VertLayout {
  uint32_t groupsX, groupsY, groups;
  uint32_t remainders; //!< the word of remainders, if present
  uint32_t margins;    //!< axis by axis, a byte per group: lower margin in bits 0..3, upper margin in bits 4..7
  uint32_t words;      //!< lower 16 bits per group
  uint32_t wordsHigh;  //!< upper 8 bits per group
  uint32_t cell;       //!< fields of the first cell
  /* in a raw block */
  uint32_t vertices; //!< x, y, z per vertex, row by row
  uint32_t boxes;    //!< plane by plane, a float per group
  uint32_t rawBytes;
};

CVERT_FUNCTION VertLayout vertLayout(uint32_t region, uint32_t info) {
  uint32_t begin = motionOffset(info) + (isMoving(info) ? vertMotionBytes : 0u);
  VertLayout offsets;
  offsets.groupsX = groupsOf(vertQuadsX(region));
  offsets.groupsY = groupsOf(vertQuadsY(region));
  offsets.groups = offsets.groupsX * offsets.groupsY;
  offsets.remainders = begin;
  offsets.margins = begin + (hasRemainders(info) ? vertRemaindersBytes : 0u);
  offsets.words = offsets.margins + ((3u * offsets.groups + 1u) & ~1u);
  offsets.wordsHigh = offsets.words + 2u * offsets.groups;
  offsets.cell = offsets.wordsHigh + offsets.groups;
  offsets.vertices = begin;
  offsets.boxes = offsets.vertices + 12u * (vertQuadsX(region) + 1u) * (vertQuadsY(region) + 1u);
  offsets.rawBytes = offsets.boxes + 4u * boxPlanes * offsets.groups;
  return offsets;
}

/* If a patch has more quads along an edge than the edge's rate, Embree stitches its border: several vertices coincide
 * with one vertex of the edge. */

/*! Returns the vertex of an edge with which vertex x of a border of `quads` quads coincides. The rate must equal quads,
 *  or be at most maxVertRate, so that the product fits into 32 bits. */
CVERT_FUNCTION uint32_t stitchedVertex(uint32_t x, uint32_t quads, uint32_t rate) {
  return rate == quads ? x : (2u * x + 1u) * rate / (2u * quads);
}

/*! Patch parameter at vertex x of a row or column of `quads` quads, as in GRID. rate: of the row's edge, or `quads`
 *  inside the patch. */
CVERT_REAL CVERT_FUNCTION Real vertParameter(uint32_t x, uint32_t quads, uint32_t rate) {
  return Real(float(stitchedVertex(x, quads, rate))) / Real(float(rate));
}

/* --- parts after the header ------------------------------------------------------------ */

/*! Returns zeros if the block stores no edges. */
CVERT_FUNCTION VertEdges edgesOf(CVERT_POINTER(VertHeader) block) {
  VertEdges edges;
  edges.low = edges.high = 0u;
  if (hasEdges(CVERT_AT(VertHeader, block).info)) edges = CVERT_AT(VertEdges, bytesAfter(block, vertHeaderBytes));
  return edges;
}

/*! Numbers as stored after the header; they may refer to VertTrianglePairs. Requires a block with numbers. */
CVERT_FUNCTION VertPrimIDs storedNumbersOf(CVERT_POINTER(VertHeader) block) {
  return CVERT_AT(VertPrimIDs, bytesAfter(block, vertHeaderBytes));
}

/*! Numbers of the quads, and distance between the numbers of a quad's triangles, 1 if not stored. Requires a block with
 *  numbers. */
CVERT_FUNCTION VertTrianglePairs trianglePairsOf(CVERT_POINTER(VertHeader) block) {
  VertTrianglePairs pairs;
  pairs.numbers = storedNumbersOf(block);
  pairs.distance = 1u;
  if (haveTrianglePairs(CVERT_AT(VertHeader, block).patchQuads)) {
    uint32_t at = pairs.numbers.x >> 2;
    pairs.numbers.x = wordAt(block, at);
    pairs.numbers.y = wordAt(block, at + 1u);
    pairs.distance = wordAt(block, at + 2u);
  }
  return pairs;
}

CVERT_FUNCTION VertPrimIDs numbersOf(CVERT_POINTER(VertHeader) block) { return trianglePairsOf(block).numbers; }

CVERT_FUNCTION VertMotion motionOf(CVERT_POINTER(VertHeader) block) {
  return CVERT_AT(VertMotion, bytesAfter(block, motionOffset(CVERT_AT(VertHeader, block).info)));
}

/*! Returns the primitive of the first or second triangle of quad x, y. Requires a block with numbers. Clamps x and y,
 *  because hits of a damaged block may lie outside it. */
CVERT_FUNCTION QuadPrimitive primitiveOfQuad(CVERT_POINTER(VertHeader) block, uint32_t x, uint32_t y, bool isSecond) {
  VertTrianglePairs pairs = trianglePairsOf(block);
  VertPrimIDs numbers = pairs.numbers;
  uint32_t numbering = CVERT_AT(VertHeader, block).patchQuads, first = CVERT_AT(VertHeader, block).primID;
  uint32_t region = CVERT_AT(VertHeader, block).region;
  uint32_t quadsX = vertQuadsX(region), quadsY = vertQuadsY(region);
  x = x < quadsX ? x : quadsX - 1u;
  y = y < quadsY ? y : quadsY - 1u;
  QuadPrimitive primitive;
  primitive.numbering = numbering;
  uint32_t number;
  if (!haveTable(numbering)) number = patternNumber(numbering, numbers, x, y);
  else {
    uint32_t entry = (y * quadsX + x) * entriesPerQuad(numbering);
    if (patternOfPrimIDs(numbering) == primIDsInTriangleTable && isSecond) entry++;
    uint32_t read = bitsAt(bytesAfter(block, numbers.x & ~3u), 8u * (numbers.x & 3u) + numbers.y * entry, numbers.y);
    number = numbers.y < 32u ? read & ((1u << numbers.y) - 1u) : read;
    if (patternOfPrimIDs(numbering) == primIDsInTriangleTable) {
      uint32_t firstCorner = number & ((1u << firstCornerBits) - 1u);
      primitive.numbering = numbering | packFirstCorners(firstCorner, firstCorner);
      primitive.primID = first + (number >> firstCornerBits);
      return primitive;
    }
  }
  primitive.primID = first + number;
  if (isTriangleNumbering(numbering) && !isSingleTriangleNumbering(numbering) && isSecond)
    primitive.primID += pairs.distance;
  return primitive;
}

CVERT_FUNCTION uint32_t numberOfQuad(CVERT_POINTER(VertHeader) block, uint32_t x, uint32_t y) {
  return primitiveOfQuad(block, x, y, false).primID;
}

CVERT_END

#ifndef VULKAN
#include <cstddef>
static_assert(sizeof(cvert::VertHeader) == cvert::vertHeaderBytes &&
                  offsetof(cvert::VertHeader, corners) == cvert::vertCornersOffset,
              "header of a block of cVERT");

CVERT_BEGIN

/*! word: of the first cell. */
inline VertSpacing vertSpacing(uint32_t word, const uint32_t corners[6]) {
  return vertSpacing(word, corners[0], corners[1], corners[2], corners[3]);
}

/*! End of VertTrianglePairs and the table of numbers, in bytes from the start of the block, or `otherwise` if the block
 *  has neither. */
inline uint32_t endOfNumbers(const VertHeader* block, uint32_t otherwise) {
  const uint32_t numbering = block->patchQuads;
  if (!hasPrimIDs(block->info)) return otherwise;
  if (haveTable(numbering)) {
    const VertPrimIDs numbers = numbersOf(block);
    const uint32_t entries = vertQuadsX(block->region) * vertQuadsY(block->region) * entriesPerQuad(numbering);
    return numbers.x + bytesOfNumberTable(entries, numbers.y);
  }
  return haveTrianglePairs(numbering) ? storedNumbersOf(block).x + uint32_t(sizeof(VertTrianglePairs)) : otherwise;
}

/*! Size of the first step in bytes, without VertTrianglePairs, table of numbers, and padding. */
inline uint32_t vertFirstStepSize(const VertHeader* block) {
  const VertLayout layout = vertLayout(block->region, block->info);
  if (isRaw(block->info)) return layout.rawBytes; // of a tile, see tileBytes
  if (hasRemainders(block->info)) {
    const uint32_t remainders = wordAt(block, layout.remainders / 4);
    return remainderOffset(remainders) + bytesOfRemainders(remainders, block->region);
  }
  return endOfFields(block, layout.cell, block->word, layout.words, layout.groups);
}

CVERT_END
#endif

#endif
