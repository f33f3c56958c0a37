// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a leaf of the top-level BVH4 refers to. Types 0 and 1 are Embree's own (GridSOA's
 * inner leaves and its root), so that patches that are not compressed live in the same tree
 * as blocks. */

#include "../framed/block.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    enum PrimitiveType : uint32_t { GRID_SOA_QUADS = 0, GRID_SOA_ROOT = 1, FIRST_BLOCK = 2 };

    /*! of a block of a kind */
    constexpr uint32_t blockType(uint32_t kind) { return FIRST_BLOCK + kind; }
  }}
}
