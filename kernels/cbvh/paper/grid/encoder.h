// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of leaves of cGRID (block_encoder.h): stores the block's vertices as floats, all x, all y, then all z. */

#include "../block_statistics.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
class GridEncoder {
public:
  GridEncoder(const BlockGeometry& geometry, Block* block, BlockStatistics&) : geometry(geometry), block(block) {}

  void encodeSiblingGroups(uint32_t, const NodeBoxes&, uint32_t*) {}
  uint32_t encodeGroup(uint32_t, const NodeBox&) { return 0; }
  void encodeLeaf(uint32_t, const NodeBox&) {}

  void finish() {
    float* out = (float*)block->leaves();
    const uint32_t count = geometry.width * geometry.width;
    for (int k = 0; k < 3; k++)
      for (uint32_t i = 0; i < count; i++)
        // rays could hit triangles with infinities, but no triangles with NaN
        *out++ = geometry.isFinite(i) ? geometry.vertices[i][k] : NAN;
    for (uint32_t i = 0; i < kindFormats[kindGrid].tailPadding / sizeof(float); i++) *out++ = 0.0f;
  }

private:
  const BlockGeometry& geometry;
  Block* block;
};
}} // namespace embree::cbvh::CBVH_ISA
