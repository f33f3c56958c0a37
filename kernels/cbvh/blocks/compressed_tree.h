// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A scene's trees: Embree's, and one of wider nodes that single rays traverse instead (wide_tree.h builds it). */

#include "../embree/traversal.h"

namespace embree {
static const size_t wideChildren = 16;

/*! Missing children have an inverted box, which no ray hits. */
struct alignas(64) WideNode {
  float planes[6][wideChildren]; //!< lower x, upper x, lower y, upper y, lower z, upper z
  size_t children[wideChildren]; //!< BVH4::NodeRef of a leaf, or address of a WideNode

  WideNode() {
    for (size_t plane = 0; plane < 6; plane++)
      for (float& value : planes[plane]) value = plane & 1 ? float(neg_inf) : float(pos_inf);
    for (size_t& child : children) child = BVH4::emptyNode;
  }

  void set(size_t i, size_t child, const BBox3fa& bounds) {
    children[i] = child;
    for (size_t axis = 0; axis < 3; axis++) {
      planes[2 * axis][i] = bounds.lower[axis];
      planes[2 * axis + 1][i] = bounds.upper[axis];
    }
  }
};

/*! A scene's tree over its static surfaces, or over its moving compressed ones: Embree's BVH4, whose leaves are
 *  blocks or grids of GRID (base/leaf_type.h). */
struct CompressedTree : public BVH4 {
  CompressedTree(const PrimitiveType& type, Scene* scene) : BVH4(type, scene), wide(scene->device, 0) {}

  float maxVertexDeviation = 0; //!< of its surfaces, see SurfaceStatistics
  mvector<WideNode> wide;       //!< the tree for single rays; empty if they traverse the BVH4
};
} // namespace embree
