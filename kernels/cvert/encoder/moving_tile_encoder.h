// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of moving tiles (format/tile.h). Lossless as TileEncoder. */

#include "motion_encoder.h"
#include "tile_encoder.h"

namespace cvert { inline namespace CVERT_ISA {
/*! Used as MotionEncoder: call begin(), then for each step set vertices() and call addStep(), then finish(). */
class MovingTileEncoder {
public:
  /*! Upper bound of a tile's size. */
  static size_t maxBytes(size_t numSteps) {
    return vertHeaderBytes + vertEdgesBytes + vertMotionBytes +
           numSteps * (sizeof(uint32_t) + stepAlignment + TileEncoder::maxBytes);
  }

  /*! Vertices of the next step, row by row, which the caller sets. */
  float (*vertices())[3] { return current.vertices; }

  /*! begin, end: times of the first and last step. numSteps: 2 to maxTimeSteps. out: receives the tile until finish(),
   *  at least maxBytes(numSteps), aligned to 4. */
  void begin(const VertPlacement& placement, float begin, float end, uint32_t numSteps, uint8_t* out) {
    const uint32_t info = placement.info() | tileInfo | 1u << 31;
    const uint32_t steps = motionOffset(info) + vertMotionBytes;
    const VertMotion motion = {begin, end, numSteps, steps};
    region = placement.region;
    tile = out;
    memset(tile, 0, vertHeaderBytes);
    placement.write(*(VertHeader*)tile, info);
    memcpy(tile + motionOffset(info), &motion, sizeof(motion));
    nextOffset = steps;
    secondStep = 0;
    size = steps + sizeof(uint32_t) * numSteps;
    isPossible = true;
  }

  void addStep() {
    current.setSize(region);
    current.computeBounds();
    if (isPossible) isPossible = current.allFinite && encodeStep();
  }

  /*! Vertices of the step that was added last. */
  const BlockVertices& last() const { return current; }

  /*! Returns the size in bytes, a multiple of 4, or 0 if the vertices must remain a block: as TileEncoder, or one is
   * not finite. The caller sets VertHeader::surface and primID. */
  size_t finish(MotionStatistics& out) const {
    out = MotionStatistics();
    if (!isPossible) return 0;
    out.stepBytes = uint32_t(size - secondStep);
    return size;
  }

private:
  static const size_t stepAlignment = 16;

  bool encodeStep() {
    while (size % stepAlignment != 0) tile[size++] = 0;
    const uint32_t offset = uint32_t(size), first = ((VertHeader*)tile)->info;
    if (nextOffset == motionOffset(first) + vertMotionBytes + sizeof(offset)) secondStep = size;
    memcpy(tile + nextOffset, &offset, sizeof(offset));
    nextOffset += sizeof(offset);
    const size_t bytes = encoder.encode(current, VertPlacement(region, 0), tile + size);
    size += bytes;
    return bytes != 0;
  }

  uint8_t* tile;
  uint32_t region;
  size_t size, nextOffset; //!< nextOffset: where the offset of the next step is stored
  size_t secondStep;       //!< offset of the second step
  bool isPossible;
  BlockVertices current;
  TileEncoder encoder;
};
}} // namespace cvert::CVERT_ISA
