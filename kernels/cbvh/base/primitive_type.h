// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a leaf of the top-level BVH4 refers to. Types 0 and 1 are Embree's own (GridSOA's
 * inner leaves and its root), so that patches that are not compressed live in the same tree
 * as blocks. Embree's reference has 3 bits for it, too few for a type a kind: a type is a form of
 * blocks, and where several kinds have one form the block's header has the kind. */

#include "codec.h"
#include <cstddef>
#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    /*! How the bytes of a block are laid out: one type in the library's parts of all instruction sets. */
    enum BlockForm : uint32_t { FRAMED_FORM, VERT_FORM, MESH_FORM };
  }

  namespace cbvh { inline namespace CBVH_ISA
  {
    enum PrimitiveType : uint32_t
    {
      GRID_SOA_QUADS = 0,
      GRID_SOA_ROOT = 1,
      FRAMED_BLOCK = 2,   //!< framed/block.h, whose info has the kind
      VERT_BLOCK = 3,     //!< cvert/format/block.h
      MOVING_VERT_BLOCK = 4, //!< cvert/format/motion.h; in a tree of its own
      MESH_BLOCK = 5        //!< cvert/format/mesh_block.h
    };

    /*! type: of a block */
    constexpr BlockForm formOfBlock (std::size_t type) {
      return type == FRAMED_BLOCK ? FRAMED_FORM : type == MESH_BLOCK ? MESH_FORM : VERT_FORM;
    }

    /*! whether it is none of Embree's own */
    constexpr bool isBlock (std::size_t type) { return type >= FRAMED_BLOCK; }
  }}
}
