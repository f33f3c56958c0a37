// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's single-ray traversal of the top-level BVH, with the rays of top_level_ray.h. intersector1.cpp has the
 * classes of leaves. */

#include "top_level_ray.h"
#include "../embree/traversal.h"

namespace embree::isa::cbvh {
/* Nodes of a tree. operator() returns the mask of children that the ray intersects, and their entry distances.
 * types: Embree's bits for the tree's types of nodes. */

/*! Nodes of the tree of surfaces at rest. */
struct StaticNodes {
  static const int types = BVH_AN1;
  __forceinline size_t operator()(BVH4::NodeRef node, const TravRay<4, true>& tray, vfloat4& distances) const {
    return intersectNodeRobust<4>(node.getAABBNode(), tray, distances);
  }
};

/*! Nodes of the tree of moving surfaces, at a time from 0 to 1. */
struct MovingNodes {
  static const int types = BVH_AN2_AN4D;
  const float time;
  __forceinline size_t operator()(BVH4::NodeRef node, const TravRay<4, true>& tray, vfloat4& distances) const {
    return intersectNodeMB4DRobust<4>(node, tray, time, distances);
  }
};

typedef StackItemT<BVH4::NodeRef> StackEntry;

/*! Entry distance of a stack entry; Embree stores its bits as an integer. */
__forceinline float distanceOf(const StackEntry& entry) {
  float distance;
  memcpy(&distance, &entry.dist, sizeof(float));
  return distance;
}

/*! Pushes a node, to be traversed next. Returns the new top of the stack. */
__forceinline StackEntry* push(StackEntry* top, BVH4::NodeRef node, float distance) {
  top->ptr = node;
  memcpy(&top->dist, &distance, sizeof(float));
  return top + 1;
}

/*! A leaf that a ray reaches. */
struct ReachedLeaf {
  const BVH4::NodeRef ref;
  const size_t mask;        //!< children of its parent that the ray intersects and that are not nearer than the leaf
  const vfloat4& distances; //!< of the parent's children

  /*! Distance to the entry into the leaf's bounds. */
  __forceinline float entryT() const { return reduce_min(select(vboolf4(int(mask)), distances, vfloat4(pos_inf))); }
};

/*! Finds the closest hit of a ray. Leaves: a class with
 *
 *     StackEntry* intersect (ray, const ReachedLeaf&, tray, stack, top)
 *       Intersects a leaf. Returns the top of the stack, on which it may push nodes. */
template<typename Nodes, typename Leaves>
__forceinline void traverseClosestHit1(BVH4::NodeRef root, const Nodes& nodes, RayHit& ray, Leaves& leaves) {
  typedef BVH4::NodeRef NodeRef;

  TopLevelRay tray(ray);
  StackEntry stack[1 + 3 * BVH4::maxDepth + 3]; // + 3: as in Embree
  StackEntry* top = stack + 1;
  stack[0].ptr = root;
  stack[0].dist = neg_inf;
  while (top != stack) {
    top--;
    NodeRef cur = NodeRef(top->ptr);
    const float entryT = distanceOf(*top);
    if (unlikely(entryT > ray.tfar)) continue;

    size_t mask = 1;
    vfloat4 distances(entryT);
    while (!cur.isLeaf()) {
      mask = nodes(cur, tray, distances);
      if (unlikely(mask == 0)) break;
      BVHNNodeTraverser1Hit<4, Nodes::types>::traverseClosestHit(cur, mask, distances, top,
                                                                 stack + sizeof(stack) / sizeof(StackEntry));
    }
    if (unlikely(mask == 0)) continue;
    top = leaves.intersect(ray, ReachedLeaf{cur, mask, distances}, tray, stack, top);
    tray.tfar = ray.tfar;
  }
}

/*! Returns true if the ray has a hit. Leaves: a class with
 *
 *     bool isOccluded (ray, leaf, tray, top)
 *       Returns true if the leaf has a hit. May push nodes on the stack, with `top`. */
template<typename Nodes, typename Leaves>
__forceinline bool traverseAnyHit1(BVH4::NodeRef root, const Nodes& nodes, Ray& ray, Leaves& leaves) {
  typedef BVH4::NodeRef NodeRef;

  const TopLevelRay tray(ray);
  NodeRef stack[1 + 3 * BVH4::maxDepth];
  NodeRef* top = stack;
  *top++ = root;
  while (top != stack) {
    NodeRef cur = *--top;
    size_t mask = 1;
    while (!cur.isLeaf()) {
      vfloat4 distances;
      mask = nodes(cur, tray, distances);
      if (unlikely(mask == 0)) break;
      BVHNNodeTraverser1Hit<4, Nodes::types>::traverseAnyHit(cur, mask, distances, top,
                                                             stack + sizeof(stack) / sizeof(NodeRef));
    }
    if (unlikely(mask == 0)) continue;
    if (leaves.isOccluded(ray, cur, tray, top)) return true;
  }
  return false;
}
} // namespace embree::isa::cbvh
