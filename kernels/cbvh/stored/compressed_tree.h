// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree
{
  /*! Tree of a scene over blocks and over grids of GRID. */
  struct CompressedTree : public BVH4
  {
    using BVH4::BVH4;
    bool hasGrids = false; //!< a geometry was given as grids, which point queries find
  };
}
