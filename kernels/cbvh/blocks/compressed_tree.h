// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree {
/*! A scene's tree over its static surfaces, or over its moving compressed ones: Embree's BVH4, whose leaves are
 *  blocks or grids of GRID (base/leaf_type.h). */
struct CompressedTree : public BVH4 {
  using BVH4::BVH4;
  bool supportsPointQueries = false; //!< false if it has only cages, which Embree's point queries skip
};
} // namespace embree
