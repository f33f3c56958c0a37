// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree
{
  /*! A scene's tree over blocks and grids of GRID. */
  struct CompressedTree : public BVH4
  {
    using BVH4::BVH4;
    bool hasGrids = false; //!< a geometry is a grid geometry, which point queries find
  };
}
