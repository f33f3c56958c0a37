// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Scalar decoding of a block's tree: the box of a child of a node or group. The first part compiles as C++ and GLSL. */

#ifndef CBVH_PAPER_TREE_H
#define CBVH_PAPER_TREE_H

#include "block.h"
#include "leaf/format.h"

CBVH_BEGIN

/*! True if words of a level are groups (leaf/format.h). nodeLevels: see BlockLayout. */
CVERT_FUNCTION bool isGroupLevel(uint32_t kind, uint32_t level, uint32_t nodeLevels) {
  return hasGroups(kind) && level + 1u == nodeLevels;
}

/*! group: the word is a group's. heights: used for groups only. parent: decoded box of the word's node. */
CVERT_FUNCTION NodeBox childBox(bool group, uint32_t word, Heights heights, int child, NodeBox parent) {
  if (group) return decodeLeaf(word, heights, child, parent).box;
  return decodeChild(word, child, parent);
}

CBVH_END

#ifndef VULKAN
#include <cstring>

CBVH_BEGIN

/*! Heights of group m of a cLEAF block. */
inline Heights heightsOf(const Block* block, uint32_t m) {
  Heights heights;
  memcpy(&heights, block->leaves() + sizeof(Heights) * size_t(m), sizeof(Heights));
  return heights;
}

/*! Box of child c of node m of a level. parent: decoded box of the node. */
inline NodeBox childBox(const Block* block, uint32_t level, uint32_t m, uint32_t c, const NodeBox& parent) {
  const bool group = isGroupLevel(kindOf(block->info), level, block->layout().nodeLevels);
  return childBox(group, block->nodes()[nodesOfLevels(level) + m], group ? heightsOf(block, m) : Heights{0, 0}, int(c),
                  parent);
}

/*! Leaf c of group m of a cLEAF block. parent: decoded box of the group. */
inline LeafPatch leafOfGroup(const Block* block, uint32_t m, uint32_t c, const NodeBox& parent) {
  const uint32_t level = block->layout().nodeLevels - 1;
  return decodeLeaf(block->nodes()[nodesOfLevels(level) + m], heightsOf(block, m), int(c), parent);
}

CBVH_END
#endif

#endif
