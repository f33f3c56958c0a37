// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's single-ray traversal of the top-level BVH, with the rays of top_level_ray.h. For closest hits it also passes
 * entry distances of blocks with frames, so that results do not depend on their order (paper/nearest_hit.h). */

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

/*! Entry distance of a stack entry; Embree stores its bits as an integer. */
__forceinline float distanceOf(const StackItemT<BVH4::NodeRef>& entry) {
  float distance;
  memcpy(&distance, &entry.dist, sizeof(float));
  return distance;
}

/*! If a stack entry is nearer than the leaf, pushes the nearest one, stores the leaf in its place, and returns
 *  true. Leaves are then visited in order of distance; Embree sorts only the children of one node. */
__forceinline bool deferToNearer(BVH4::NodeRef leaf, float entryT, StackItemT<BVH4::NodeRef>* stack,
                                 StackItemT<BVH4::NodeRef>*& top) {
  StackItemT<BVH4::NodeRef>* nearest = nullptr;
  float least = entryT;
  for (StackItemT<BVH4::NodeRef>* entry = stack; entry != top; entry++) {
    const float distance = distanceOf(*entry);
    if (unlikely(distance < least)) {
      least = distance;
      nearest = entry;
    }
  }
  if (likely(nearest == nullptr)) return false;
  *top++ = *nearest;
  nearest->ptr = leaf;
  memcpy(&nearest->dist, &entryT, sizeof(float));
  return true;
}

/*! Finds the closest hit of a ray. LeafIntersector: a class with
 *
 *     bool isSorted
 *       True if blocks with frames must be visited in order of distance, so that each hit that a filter function
 *       accepts is nearer than the one before.
 *     static bool hasFrame (leaf)
 *       True for a block with a frame. Other leaves cannot be hit before their bounds.
 *     void setEntryT (t)
 *       Sets the entry distance of the next block with a frame.
 *     void intersect (leaf, tray, lazyNode)
 *       Intersects a leaf. lazyNode: receives a node that must be traversed next. */
template<typename Nodes, typename LeafIntersector>
__forceinline void traverseClosestHit1(BVH4::NodeRef root, const Nodes& nodes, RayHit& ray, LeafIntersector& leaves) {
  typedef BVH4::NodeRef NodeRef;
  typedef StackItemT<NodeRef> Entry;

  TopLevelRay tray(ray);
  Entry stack[1 + 3 * BVH4::maxDepth + 3]; // + 3: as in Embree
  Entry* top = stack + 1;
  stack[0].ptr = root;
  stack[0].dist = neg_inf;
  while (top != stack) {
    top--;
    NodeRef cur = NodeRef(top->ptr);
    float entryT = distanceOf(*top);
    if (unlikely(entryT > ray.tfar)) continue;

    size_t mask = 1;
    vfloat4 distances(entryT);
    while (!cur.isLeaf()) {
      mask = nodes(cur, tray, distances);
      if (unlikely(mask == 0)) break;
      BVHNNodeTraverser1Hit<4, Nodes::types>::traverseClosestHit(cur, mask, distances, top,
                                                                 stack + sizeof(stack) / sizeof(Entry));
    }
    if (unlikely(mask == 0)) continue;
    if (LeafIntersector::hasFrame(cur)) {
      entryT = reduce_min(select(vboolf4(int(mask)), distances, vfloat4(pos_inf)));
      if (unlikely(leaves.isSorted) && deferToNearer(cur, entryT, stack, top)) continue;
      leaves.setEntryT(entryT);
    }
    size_t lazyNode = 0;
    leaves.intersect(cur, tray, lazyNode);
    tray.tfar = ray.tfar;
    if (unlikely(lazyNode)) {
      top->ptr = lazyNode;
      top->dist = neg_inf;
      top++;
    }
  }
}

/*! Returns true if isOccluded(leaf,tray,lazyNode) is true for a leaf that the ray reaches. lazyNode: as above. */
template<typename Nodes, typename IsOccluded>
__forceinline bool traverseAnyHit1(BVH4::NodeRef root, const Nodes& nodes, const Ray& ray,
                                   const IsOccluded& isOccluded) {
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
    size_t lazyNode = 0;
    if (isOccluded(cur, tray, lazyNode)) return true;
    if (unlikely(lazyNode)) *top++ = NodeRef(lazyNode);
  }
  return false;
}
} // namespace embree::isa::cbvh
