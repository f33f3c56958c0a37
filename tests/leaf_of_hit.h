// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The leaves of a scene's blocks that a hit may lie in, by its parameters, and what they
 * decode to, by the kind of their block: FORMAT.md. */

#include "kernels/cbvh/block.h"
#include "kernels/cbvh/leaf_codec.h"
#include <embree3/rtcore.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace cbvh {

struct LeafOfBlock
{
  const embree::cbvh::Block* block;
  uint32_t leaf; // Morton index; of a group of 2 x 2 quads in cGRID, of a quarter where cLEAF has one quad
};

// Several on the border of two.
inline std::vector<LeafOfBlock> leavesOfHit(const std::vector<const embree::cbvh::Block*>& blocks, const RTCHit& hit)
{
  std::vector<LeafOfBlock> leaves;
  for (const embree::cbvh::Block* block : blocks) {
    if (block->primID != hit.primID) continue;
    const double cells = 1u << block->layout().nodeLevels, quads = 1u << block->height();
    const double x = ((hit.u - block->u0*0.5)*block->quadsX() - block->blockX()*quads)*cells/quads;
    const double y = ((hit.v - block->v0*0.5)*block->quadsY() - block->blockY()*quads)*cells/quads;
    const double rounding = 1e-3; // of parameters
    for (double i = std::floor(x - rounding); i <= x + rounding; i++)
      for (double j = std::floor(y - rounding); j <= y + rounding; j++)
        if (i >= 0 && j >= 0 && i < cells && j < cells) leaves.push_back({block, embree::cbvh::morton(uint32_t(i), uint32_t(j))});
  }
  return leaves;
}

// Words of nodes down to the last level, whose words are those of groups in cLEAF. Only cLEAF has
// more than the box.
inline embree::cbvh::LeafPatch decodeLeafOfBlock(const LeafOfBlock& at)
{
  using namespace embree::cbvh;
  const uint32_t levels = at.block->layout().nodeLevels;
  LeafPatch patch = {};
  patch.box = NodeBox::root();
  for (uint32_t level = 0; level < levels; level++) {
    const uint32_t m = at.leaf >> 2*(levels - level);
    const int child = int(at.leaf >> 2*(levels - level - 1)) & 3;
    const uint32_t word = at.block->nodes()[nodesOfLevels(level) + m];
    if (at.block->kind() == Kind::LEAF && level + 1 == levels) {
      uint64_t heights;
      std::memcpy(&heights, at.block->leaves() + 8*size_t(m), sizeof(heights));
      return decodeLeaf(word, heights, child, patch.box);
    }
    patch.box = decodeChild(word, child, patch.box);
  }
  return patch;
}

} // namespace cbvh
