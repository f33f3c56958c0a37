// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The types of blocks. Functions that differ by type switch over BlockType without a default. The library is compiled
 * with -Werror=switch, so that no function can forget a new type. docs/architecture.md lists them. */

#include <cstdint>

namespace cvert {
/*! The numbers are those of leaves in memory (embree::cbvh, base/leaf_type.h), and of children in files
 *  (file/format.h), where 1 is added for moving blocks. No number is free, because numbers of leaves in memory have 3
 *  bits: a further form of blocks has to share a type and differ in its header. Headers store whether a block moves. */
enum BlockType : uint32_t {
  FRAMED_BLOCK = 2, //!< block with a frame, of the paper's kinds. Its header stores the kind. Never moves
  VERT_BLOCK = 3,   //!< format/block.h, with format/motion.h if it moves
  MESH_BLOCK = 5,   //!< format/mesh_block.h, with format/mesh_motion.h if it moves
  TILE_BLOCK = 7    //!< format/tile.h. Not in files
};
} // namespace cvert
