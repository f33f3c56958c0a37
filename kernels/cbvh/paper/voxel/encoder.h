// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of leaves of cVOXEL (block_encoder.h). Only collects statistics: the boxes of leaves are the surface. */

#include "../block_statistics.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
class VoxelEncoder {
public:
  VoxelEncoder(const BlockGeometry& geometry, Block*, BlockStatistics& statistics)
    : geometry(geometry),
      statistics(statistics) {}

  void encodeSiblingGroups(uint32_t, const NodeBoxes&, uint32_t*) {}
  uint32_t encodeGroup(uint32_t, const NodeBox&) { return 0; }

  void encodeLeaf(uint32_t m, const NodeBox& box) {
    if (geometry.boxOf(geometry.cellLevels, m).empty()) return;
    statistics.addBoxThickness(geometry, box);
    statistics.leafFit.addFlatQuad(geometry, mortonX(m), mortonY(m), box);
  }

  void finish() {}

private:
  const BlockGeometry& geometry;
  BlockStatistics& statistics;
};
}} // namespace embree::cbvh::CBVH_ISA
