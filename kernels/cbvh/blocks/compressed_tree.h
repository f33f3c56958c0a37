// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "wide_tree.h"

namespace embree {
/*! A scene's tree over its static surfaces, or over its moving compressed ones: Embree's BVH4, whose leaves are
 *  blocks or grids of GRID (base/leaf_type.h). */
struct CompressedTree : public BVH4 {
  CompressedTree(const PrimitiveType& type, Scene* scene) : BVH4(type, scene), wide(scene->device, 0) {}

  bool supportsPointQueries = false; //!< false if it has only cages, which Embree's point queries skip
  mvector<WideNode> wide;            //!< the tree for single rays; empty if they traverse the BVH4
};
} // namespace embree
