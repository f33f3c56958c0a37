// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A tile: a block (block.h) in another form, which is about twice as large. Each vertex and each box can be
 * read without the others, so that a ray decodes only what it tests. Tiles are made from blocks in memory, with the
 * very same vertices; files contain blocks. docs/formats/tile.md specifies the form. Layout:
 *
 *   header | edges of the patch, or primitive numbers | padding to 16 bytes | boxes | vertices | table of primitive
 *   numbers
 *
 * The header is a VertHeader, whose members bounds, corners and word store the fields below. On each axis, vertex (x,y)
 * of the tile is
 *
 *   origin + (base * scale + x slopeX + y slopeY + residual) * spacing,
 *
 * where the sum in parentheses, the coordinate, is an integer of tileExtentBits. Those of blocks are below
 * maxExtent, and have remainders if the vertices' lattice is finer; tiles have none. The residuals of a vertex are
 * packed into 2, 3, 4 or 5 bytes, those on x and y into the lower four. If the lattice is still finer, or if residuals
 * need more bits, the tile stores floats.
 *
 * A leaf is 4 x 2 quads. Its box has six bytes: planes are origin + byte * boxStep * scale * spacing. Rows and columns
 * of vertices are repeated up to whole leaves; quads between them have no area and are never hit.
 *
 * A moving tile has a tile at rest per time step, without edges and numbers, which begins at a multiple of 16 bytes:
 *
 *   header | edges or numbers | VertMotion | offsets of steps | step 0 | step 1 | ... | table of primitive numbers
 *
 * Its header has only surface, primID, region, patchQuads and info. Vertices and boxes are linear in a segment, the
 * time between two steps. */

#ifndef CVERT_FORMAT_TILE_H
#define CVERT_FORMAT_TILE_H

#include "block.h"

CVERT_BEGIN

CVERT_CONSTANT uint32_t leafQuadsX = 4u; //!< quads of a leaf
CVERT_CONSTANT uint32_t leafQuadsY = 2u;
CVERT_CONSTANT uint32_t tileLeavesX = 4u;                   //!< columns of boxes, also in narrower tiles
CVERT_CONSTANT uint32_t leavesPerPart = 16u;                //!< boxes are stored for this many leaves at a time
CVERT_CONSTANT uint32_t tilePartBytes = 6u * leavesPerPart; //!< lower x, upper x, lower y, ... of 16 leaves each
CVERT_CONSTANT uint32_t minTileQuads = 64u;                 //!< blocks of fewer quads remain as they are
CVERT_CONSTANT uint32_t maxTileVertexBytes = 5u;            //!< of packed residuals
CVERT_CONSTANT uint32_t tileFloatBytes = 12u;               //!< bytes per vertex of a tile with floats
CVERT_CONSTANT uint32_t maxBoxByte = 255u;
CVERT_CONSTANT uint32_t tileExtentBits = 18u;

/*! Bits of VertHeader::info in a tile. Other bits: 29, 30, 31 as in a block. */
CVERT_CONSTANT uint32_t tileInfo = rawInfo | (1u << 14);

/*! True for a tile, false for a block: raw blocks have no shear, whose lowest bit this is. */
CVERT_FUNCTION bool isTile(uint32_t info) { return (info & tileInfo) == tileInfo; }

/* Fields, by byte offset in the header:
 *
 *   12   bits 0..15: order of leaves, see leafFlip. Bits 16..19: bytes per vertex, 2 to 5, or 12. Bits 20, 21: binary
 *        logarithm of scale
 *   32   slopeX on x, y, z, 16 bits each, signed
 *   38   slopeY
 *   44   base
 *   50   spacing on x, y, z, a biased exponent of a float, 8 bits each
 *   53   boxStep, 8 bits each
 *   60   bits 0..4, 5..9, 10..14: bits of a residual on x, y, z */
CVERT_CONSTANT uint32_t tileOrderOffset = 12u;
CVERT_CONSTANT uint32_t tileSlopeXOffset = 32u;
CVERT_CONSTANT uint32_t tileSlopeYOffset = 38u;
CVERT_CONSTANT uint32_t tileBaseOffset = 44u;
CVERT_CONSTANT uint32_t tileSpacingOffset = 50u;
CVERT_CONSTANT uint32_t tileBoxStepOffset = 53u;
CVERT_CONSTANT uint32_t tileBitsOffset = 60u;

CVERT_FUNCTION uint32_t tileVertexBytes(CVERT_POINTER(VertHeader) tile) {
  return (CVERT_AT(VertHeader, tile).bounds >> 16) & 15u;
}

CVERT_FUNCTION int tileScale(CVERT_POINTER(VertHeader) tile) {
  return 1 << ((CVERT_AT(VertHeader, tile).bounds >> 20) & 3u);
}

CVERT_FUNCTION int tileInt16(CVERT_POINTER(VertHeader) tile, uint32_t offset, int axis) {
  return int(uint16At(CVERT_AS(void, tile), offset + 2u * uint32_t(axis)) << 16) >> 16;
}
CVERT_FUNCTION float tileSpacing(CVERT_POINTER(VertHeader) tile, int axis) {
  return floatOfBits(byteAt(CVERT_AS(void, tile), tileSpacingOffset + uint32_t(axis)) << 23);
}

/*! Distance between neighboring planes of boxes. */
CVERT_FUNCTION float tileBoxUnit(CVERT_POINTER(VertHeader) tile, int axis) {
  uint32_t steps = byteAt(CVERT_AS(void, tile), tileBoxStepOffset + uint32_t(axis)) * uint32_t(tileScale(tile));
  return float(steps) * tileSpacing(tile, axis);
}

CVERT_FUNCTION uint32_t tileBits(CVERT_POINTER(VertHeader) tile, int axis) {
  return (CVERT_AT(VertHeader, tile).word >> (5u * uint32_t(axis))) & 31u;
}

/*! By which number the index of a leaf is changed (exclusive or) to visit leaves roughly front to back: bits 0..1
 *  reverse columns, bits 2..4 rows. octant: bit k is set if the ray's direction is negative on axis k. */
CVERT_FUNCTION uint32_t leafFlip(CVERT_POINTER(VertHeader) tile, uint32_t octant) {
  uint32_t order = (CVERT_AT(VertHeader, tile).bounds >> (2u * octant)) & 3u;
  return ((order & 1u) != 0u ? 3u : 0u) | ((order & 2u) != 0u ? 28u : 0u);
}

/*! Leaves along a side of a tile with `quads` quads. */
CVERT_FUNCTION uint32_t leavesAlongX(uint32_t quads) { return (quads + leafQuadsX - 1u) / leafQuadsX; }
CVERT_FUNCTION uint32_t leavesAlongY(uint32_t quads) { return (quads + leafQuadsY - 1u) / leafQuadsY; }

/*! Vertices per stored row, and stored rows. */
CVERT_FUNCTION uint32_t tileRowVertices(uint32_t region) { return leafQuadsX * leavesAlongX(vertQuadsX(region)) + 1u; }
CVERT_FUNCTION uint32_t tileRows(uint32_t region) { return leafQuadsY * leavesAlongY(vertQuadsY(region)) + 1u; }

/*! Parts of boxes: 1 or 2. */
CVERT_FUNCTION uint32_t tileParts(uint32_t region) {
  return (tileLeavesX * leavesAlongY(vertQuadsY(region)) + leavesPerPart - 1u) / leavesPerPart;
}

/*! Mask of the leaves that exist. Leaf (column, row) is bit column + 4 row. */
CVERT_FUNCTION uint32_t tileLeaves(uint32_t region) {
  uint32_t columns = ((1u << leavesAlongX(vertQuadsX(region))) - 1u) * 0x11111111u;
  uint32_t leaves = tileLeavesX * leavesAlongY(vertQuadsY(region));
  return leaves == 32u ? columns : columns & ((1u << leaves) - 1u);
}

/*! Byte offsets in a tile. */
CVERT_FUNCTION uint32_t tileBoxesOffset(uint32_t info) { return (motionOffset(info) + 15u) & ~15u; }
CVERT_FUNCTION uint32_t tileVerticesOffset(uint32_t region, uint32_t info) {
  return tileBoxesOffset(info) + tilePartBytes * tileParts(region);
}
/*! End of the vertices, a multiple of 4. */
CVERT_FUNCTION uint32_t tileEnd(uint32_t region, uint32_t info, uint32_t bytesPerVertex) {
  return (tileVerticesOffset(region, info) + bytesPerVertex * tileRowVertices(region) * tileRows(region) + 3u) & ~3u;
}

/*! Plane of a leaf's box: byte of the lower (side 0) or upper (side 1) plane on an axis. */
CVERT_FUNCTION uint32_t tilePlane(CVERT_POINTER(VertHeader) tile, uint32_t leaf, int axis, uint32_t side) {
  uint32_t part = leaf / leavesPerPart;
  return byteAt(CVERT_AS(void, tile), tileBoxesOffset(CVERT_AT(VertHeader, tile).info) + tilePartBytes * part +
                                          leavesPerPart * (2u * uint32_t(axis) + side) + leaf % leavesPerPart);
}

/* Vertices of 2, 3 and 4 bytes are stored one after the other. Of 5 bytes, the lower four of all vertices precede the
 * upper bytes. The residual on x is in the lowest bits, followed by y and z. Floats are stored as three planes: all x,
 * all y, all z. */

/*! Coordinate of vertex (x,y), stored at `index` (column + tileRowVertices * row), on an axis. Requires a tile without
 *  floats. */
CVERT_FUNCTION int tileCoordinate(CVERT_POINTER(VertHeader) tile, uint32_t x, uint32_t y, int axis) {
  CVERT_POINTER(void) data = CVERT_AS(void, tile);
  uint32_t region = CVERT_AT(VertHeader, tile).region;
  uint32_t vertices = tileVerticesOffset(region, CVERT_AT(VertHeader, tile).info);
  uint32_t row = tileRowVertices(region), index = y * row + x;
  uint32_t bytes = tileVertexBytes(tile), stride = bytes < 4u ? bytes : 4u;
  uint32_t low = 0u;
  for (uint32_t i = 0u; i < stride; i++) low |= byteAt(data, vertices + stride * index + i) << (8u * i);
  uint32_t bits0 = tileBits(tile, 0), bits1 = tileBits(tile, 1), bits = tileBits(tile, axis);
  uint32_t shift = axis == 0 ? 0u : axis == 1 ? bits0 : bits0 + bits1;
  uint32_t residual = shift < 32u ? low >> shift : 0u;
  if (bytes == 5u && axis == 2) {
    uint32_t high = byteAt(data, vertices + 4u * row * tileRows(region) + index);
    residual |= shift == 32u ? high : high << (32u - shift);
  }
  return tileInt16(tile, tileBaseOffset, axis) * tileScale(tile) + int(x) * tileInt16(tile, tileSlopeXOffset, axis) +
         int(y) * tileInt16(tile, tileSlopeYOffset, axis) + int(residual & ((1u << bits) - 1u));
}

/*! World position of vertex (x,y) on an axis. The sum is exact, see block.h. */
CVERT_FUNCTION float tileVertex(CVERT_POINTER(VertHeader) tile, uint32_t x, uint32_t y, int axis) {
  if (tileVertexBytes(tile) == tileFloatBytes) {
    uint32_t region = CVERT_AT(VertHeader, tile).region, row = tileRowVertices(region);
    return floatAt(CVERT_AS(void, tile), tileVerticesOffset(region, CVERT_AT(VertHeader, tile).info) / 4u +
                                             uint32_t(axis) * row * tileRows(region) + y * row + x);
  }
  CVERT_PRECISE float at =
      CVERT_AT(VertHeader, tile).origin[axis] + float(tileCoordinate(tile, x, y, axis)) * tileSpacing(tile, axis);
  return at;
}

CVERT_END

#ifndef VULKAN
CVERT_BEGIN

/*! Returns the tile of a time step. step: 0 unless the tile moves. */
inline const VertHeader* tileOfStep(const VertHeader* tile, uint32_t step) {
  if (!isMoving(tile->info)) return tile;
  return (const VertHeader*)((const uint8_t*)tile + wordAt(tile, motionOf(tile).steps / 4 + step));
}

/*! For tiles of any kind: true if it was made from a mesh block (mesh_tile.h), and has 0 instead of tileInfo. */
inline bool isMeshTile(const void* tile) { return ((const VertHeader*)tile)->info == 0; }

/*! End of the vertices of all steps, a multiple of 4. */
inline uint32_t endOfTileSteps(const VertHeader* tile) {
  const VertHeader* last = tileOfStep(tile, isMoving(tile->info) ? motionOf(tile).numSteps - 1 : 0);
  return uint32_t((const uint8_t*)last - (const uint8_t*)tile) +
         tileEnd(last->region, last->info, tileVertexBytes(last));
}

/*! Size of a tile in bytes, without padding. */
inline uint32_t tileBytes(const VertHeader* tile) { return endOfNumbers(tile, endOfTileSteps(tile)); }

CVERT_END
#endif

#endif
