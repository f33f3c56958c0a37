// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Types of leaves of a scene's BVH4s, one over static and one over moving surfaces (blocks/compressed_tree.h). Types 0
 * and 1 are Embree's (GridSOA's inner leaves and root), so that a tree can contain blocks and uncompressed patches.
 * Embree's references have only 3 type bits. Therefore a type selects only the format of a block; the header of a block
 * with a frame stores its kind. */

#include "codec_names.h"
#include <cstddef>
#include <cstdint>

namespace embree {
namespace cbvh {
/*! Format of a block's bytes. Outside of CBVH_ISA, because all ISAs share it. */
enum BlockFormat : uint32_t { FRAMED_FORMAT, VERT_FORMAT, MESH_FORMAT };
} // namespace cbvh

namespace cbvh { inline namespace CBVH_ISA {
enum PrimitiveType : uint32_t {
  GRID_SOA_QUADS = 0,
  GRID_SOA_ROOT = 1,
  FRAMED_BLOCK = 2,      //!< paper/block.h; the header stores the kind
  VERT_BLOCK = 3,        //!< cvert/format/block.h
  MOVING_VERT_BLOCK = 4, //!< cvert/format/motion.h; in the tree of moving surfaces
  MESH_BLOCK = 5,        //!< cvert/format/mesh_block.h
  MOVING_MESH_BLOCK = 6  //!< cvert/format/mesh_motion.h; in the tree of moving surfaces
};

/*! type: a PrimitiveType for which isBlock() is true. */
constexpr BlockFormat formatOfBlock(std::size_t type) {
  return type == FRAMED_BLOCK                              ? FRAMED_FORMAT
         : type == MESH_BLOCK || type == MOVING_MESH_BLOCK ? MESH_FORMAT
                                                           : VERT_FORMAT;
}

/*! Moving blocks of files were checked when they were loaded: they need no isBlockValid(). */
constexpr bool isMovingBlock(std::size_t type) { return type == MOVING_VERT_BLOCK || type == MOVING_MESH_BLOCK; }

constexpr bool isBlock(std::size_t type) { return type >= FRAMED_BLOCK; }
}} // namespace cbvh::CBVH_ISA
} // namespace embree
