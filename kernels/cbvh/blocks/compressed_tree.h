// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A scene's trees: Embree's, and one of wider nodes that single rays traverse instead (wide_tree.h builds it), at rest
 * or moving. */

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

  /*! Copies child c of a node of the BVH4 as child i, with another reference. */
  void set(size_t i, size_t child, const BVH4::AABBNode& from, size_t c) {
    children[i] = child;
    const vfloat4* const its = &from.lower_x; // in the same order
    for (size_t plane = 0; plane < 6; plane++) planes[plane][i] = its[plane][c];
  }
};

/*! At time t, planes are planes + t * differences, as in Embree's nodes. */
struct alignas(64) WideMovingNode : public WideNode {
  float differences[6][wideChildren];

  WideMovingNode() { memset(differences, 0, sizeof(differences)); }

  void set(size_t i, size_t child, const BVH4::AABBNodeMB& from, size_t c) {
    children[i] = child;
    const vfloat4* const its = &from.lower_x; // lower x, upper x, lower y, ..., then the differences
    for (size_t plane = 0; plane < 6; plane++) {
      planes[plane][i] = its[plane][c];
      differences[plane][i] = its[6 + plane][c];
    }
  }
};

/*! A scene's tree over its static surfaces, or over its moving compressed ones: Embree's BVH4, whose leaves are
 *  blocks or grids of GRID (base/leaf_type.h). */
struct CompressedTree : public BVH4 {
  CompressedTree(const PrimitiveType& type, Scene* scene)
    : BVH4(type, scene),
      wide(scene->device, 0),
      wideMoving(scene->device, 0) {}

  float maxVertexDeviation = 0; //!< of its surfaces, see SurfaceStatistics
  /*! The tree for single rays, its root first, of a scene's static or moving surfaces. Empty if they traverse the
   *  BVH4. */
  mvector<WideNode> wide;
  mvector<WideMovingNode> wideMoving;
};
} // namespace embree
