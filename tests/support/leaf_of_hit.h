// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The leaves that may contain a hit, by its parameters, decoded as kernels/cbvh/paper/README.md specifies. */

#include "kernels/cbvh/paper/tree.h"
#include <embree3/rtcore.h>

#include <cmath>
#include <vector>

namespace programs::test {

struct LeafOfBlock {
  const embree::cbvh::Block* block;
  uint32_t leaf; // Morton index; in cGRID of 2 x 2 quads, else of a quad, or of a quarter of a cLEAF block's only quad
};

// Returns several leaves if the hit is on their common border.
inline std::vector<LeafOfBlock> leavesOfHit(const std::vector<const embree::cbvh::Block*>& blocks, const RTCHit& hit) {
  std::vector<LeafOfBlock> leaves;
  for (const embree::cbvh::Block* block : blocks) {
    if (block->primID != hit.primID) continue;
    const double cells = 1u << block->layout().nodeLevels, quads = 1u << block->height();
    const double x = ((hit.u - embree::cbvh::cornerUOf(block->tiling) * 0.5) * block->quadsX() -
                      embree::cbvh::blockXOf(block->info) * quads) *
                     cells / quads;
    const double y = ((hit.v - embree::cbvh::cornerVOf(block->tiling) * 0.5) * block->quadsY() -
                      embree::cbvh::blockYOf(block->info) * quads) *
                     cells / quads;
    const double rounding = 1e-3; // of parameters
    for (double i = std::floor(x - rounding); i <= x + rounding; i++)
      for (double j = std::floor(y - rounding); j <= y + rounding; j++)
        if (i >= 0 && j >= 0 && i < cells && j < cells)
          leaves.push_back({block, embree::cbvh::morton(uint32_t(i), uint32_t(j))});
  }
  return leaves;
}

// Decodes words of nodes down to the last level; in cLEAF the words of that level belong to groups. Only cLEAF has
// more than a box.
inline embree::cbvh::LeafPatch decodeLeafOfBlock(const LeafOfBlock& at) {
  using namespace embree::cbvh;
  const uint32_t levels = at.block->layout().nodeLevels;
  LeafPatch patch = {};
  patch.box = rootBox();
  for (uint32_t level = 0; level < levels; level++) {
    const uint32_t m = at.leaf >> 2 * (levels - level), child = (at.leaf >> 2 * (levels - level - 1)) & 3;
    if (isGroupLevel(kindOf(at.block->info), level, levels)) return leafOfGroup(at.block, m, child, patch.box);
    patch.box = childBox(at.block, level, m, child, patch.box);
  }
  return patch;
}

} // namespace programs::test
