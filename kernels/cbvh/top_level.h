// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a leaf of the top-level BVH4 refers to. Types 0 and 1 are Embree's own
 * (GridSOA's inner leaves and its root), so that patches that are not compressed
 * live in the same tree as blocks. */

#include "block.h"

namespace embree
{
  namespace cbvh
  {
    enum LeafType { GRID_SOA_QUADS = 0, GRID_SOA_ROOT = 1, GRID_BLOCK = 2, VOXEL_BLOCK = 3, LEAF_BLOCK = 4 };

    inline LeafType leafType(Kind kind) {
      return kind == Kind::GRID ? GRID_BLOCK : kind == Kind::VOXEL ? VOXEL_BLOCK : LEAF_BLOCK;
    }
  }
  namespace isa {
    namespace cbvh {
      using namespace embree::cbvh;
    }
  }
}
