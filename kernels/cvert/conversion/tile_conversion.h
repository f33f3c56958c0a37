// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts blocks to tiles (format/tile.h) and back, with the same vertices, steps, edges and primitive numbers. */

#include "../decoder/decoded_block.h"
#include "../encoder/moving_tile_encoder.h"
#include "../encoder/prim_id_encoder.h"
#include "../encoder/tile_encoder.h"

namespace cvert { inline namespace CVERT_ISA {
/*! Upper bound of the bytes that blockOfTile() writes, and for tileOfBlock(). */
static const size_t maxBlockBytesOfTile = VertEncoder::maxBytes + NumbersEncoder::maxBytes;
static const size_t maxTileBytesOfBlock = TileEncoder::maxBytes + NumbersEncoder::maxBytes;

/*! Placement with the parts after the header; numbers still refer to their places in `from`. */
inline VertPlacement placementOf(const VertHeader* from) {
  if (hasPrimIDs(from->info)) return VertPlacement(from->region, from->patchQuads, storedNumbersOf(from));
  if (hasEdges(from->info)) return VertPlacement(from->region, from->patchQuads, edgesOf(from));
  return VertPlacement(from->region, from->patchQuads);
}

/*! Copies what the encoders do not write: surface, primitive, and the numbers after the vertices. fromEnd, toEnd: end
 *  of the vertices, multiples of 4. fromBytes: size of `from`. Returns the size of `to`. */
inline size_t copyNumbers(const VertHeader* from, uint32_t fromEnd, uint32_t fromBytes, VertHeader* to,
                          uint32_t toEnd) {
  to->surface = from->surface;
  to->primID = from->primID;
  if (fromBytes <= fromEnd) return toEnd;
  std::memcpy((uint8_t*)to + toEnd, (const uint8_t*)from + fromEnd, fromBytes - fromEnd);
  auto move = [&](uint8_t* at) {
    uint32_t offset;
    std::memcpy(&offset, at, sizeof(offset));
    offset += toEnd - fromEnd;
    std::memcpy(at, &offset, sizeof(offset));
  };
  // the pairs, if any, precede the table
  if (haveTrianglePairs(from->patchQuads) && haveTable(from->patchQuads)) move((uint8_t*)to + toEnd);
  move((uint8_t*)to + vertHeaderBytes);
  return toEnd + (fromBytes - fromEnd);
}

/*! Writes the block of a tile. block: maxBlockBytesOfTile, aligned to 4. Returns its size. */
inline size_t blockOfTile(const VertHeader* tile, VertEncoder& encoder, uint8_t* block) {
  encoder.setSize(tile->region);
  for (uint32_t y = 0, i = 0; y <= encoder.quads[1]; y++)
    for (uint32_t x = 0; x <= encoder.quads[0]; x++, i++)
      for (int k = 0; k < 3; k++) encoder.vertices[i][k] = tileVertex(tile, x, y, k);
  VertStatistics statistics;
  const size_t end = encoder.encode(placementOf(tile), block, statistics);
  return copyNumbers(tile, tileEnd(tile->region, tile->info, tileVertexBytes(tile)), tileBytes(tile),
                     (VertHeader*)block, uint32_t(end));
}

/*! Writes the tile of a block at rest. decoded: the block's vertices, row by row. vertices: only for temporary use.
 * tile: maxTileBytesOfBlock, aligned to 4. Returns its size, or 0 if there is none, see TileEncoder. */
inline size_t tileOfBlock(const VertHeader* block, const float (*decoded)[3], BlockVertices& vertices,
                          TileEncoder& encoder, uint8_t* tile) {
  vertices.setSize(block->region);
  std::memcpy(vertices.vertices, decoded, sizeof(vertices.vertices[0]) * vertices.numVertices());
  vertices.computeBounds();
  if (!vertices.anyFinite()) return 0;
  const size_t end = encoder.encode(vertices, placementOf(block), tile);
  if (end == 0) return 0;
  return copyNumbers(block, (vertFirstStepSize(block) + 3) & ~3u, vertBytes(block), (VertHeader*)tile, uint32_t(end));
}

/*! Upper bound of the bytes that movingBlockOfTile() and movingTileOfBlock() write. */
inline size_t maxBytesOfMovingForms(uint32_t numSteps) {
  return std::max(MotionEncoder::maxBytes(numSteps), MovingTileEncoder::maxBytes(numSteps)) + NumbersEncoder::maxBytes;
}

/*! Encodes the steps of a moving block or tile in the other form. Encoder: MotionEncoder or MovingTileEncoder. Returns
 *  the size without numbers, or 0, see MovingTileEncoder. */
template<typename Encoder>
size_t encodeStepsOf(const VertHeader* from, Encoder& encoder, uint8_t* to, MotionStatistics& statistics) {
  const VertMotion motion = motionOf(from);
  encoder.begin(placementOf(from), motion.begin, motion.end, motion.numSteps, to);
  for (uint32_t step = 0; step < motion.numSteps; step++) {
    const DecodedBlock decoded(from, step);
    std::memcpy(encoder.vertices(), decoded.vertices,
                sizeof(decoded.vertices[0]) * (decoded.quadsX + 1) * (decoded.quadsY + 1));
    encoder.addStep();
  }
  return encoder.finish(statistics);
}

/*! Writes the block of a moving tile. block: maxBytesOfMovingForms, aligned to 4. Returns its size. */
inline size_t movingBlockOfTile(const VertHeader* tile, MotionEncoder& encoder, uint8_t* block,
                                MotionStatistics& statistics) {
  const size_t end = encodeStepsOf(tile, encoder, block, statistics);
  return copyNumbers(tile, endOfTileSteps(tile), tileBytes(tile), (VertHeader*)block, uint32_t(end));
}

/*! Writes the tile of a moving block. tile: as above. Returns its size, or 0 if there is none, see MovingTileEncoder.
 */
inline size_t movingTileOfBlock(const VertHeader* block, MovingTileEncoder& encoder, uint8_t* tile,
                                MotionStatistics& statistics) {
  const size_t end = encodeStepsOf(block, encoder, tile, statistics);
  if (end == 0) return 0;
  return copyNumbers(block, (endOfSteps(block) + 3) & ~3u, vertBytes(block), (VertHeader*)tile, uint32_t(end));
}

/*! MotionStatistics::stepBytes of a block or tile, 0 for those at rest. */
inline uint32_t laterStepBytes(const VertHeader* block) {
  if (!isMoving(block->info)) return 0;
  if (isTile(block->info))
    return endOfTileSteps(block) - uint32_t((const uint8_t*)tileOfStep(block, 1) - (const uint8_t*)block);
  return ((endOfSteps(block) + 3) & ~3u) - motionOf(block).steps;
}

/*! True for a block, not a tile, that stores floats at one of its steps. */
inline bool isAnyStepRaw(const VertHeader* block) {
  if (isTile(block->info)) return false;
  bool isAny = isRaw(block->info);
  if (isMoving(block->info))
    for (uint32_t step = 1; step < motionOf(block).numSteps; step++) isAny |= isRaw(stepOf(block, step)->info);
  return isAny;
}
}} // namespace cvert::CVERT_ISA
