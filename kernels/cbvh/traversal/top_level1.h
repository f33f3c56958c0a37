// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray traversals of a scene's trees, with the rays of top_level_ray.h: Embree's of the BVH4, then one of wide
 * nodes, whose boxes are tested by the same operations. intersector1.cpp has the classes of leaves. */

#include "top_level_ray.h"
#include "../blocks/compressed_tree.h"
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

/* --- wide nodes ----------------------------------------------------------------------- */

class WideRay {
public:
  static const int vectors = int(wideChildren) / vectorWidth;

  /*! o, d: origin and direction, see loadOfRay. Requires isValidRay(). */
  __forceinline WideRay(const Ray& ray, const vfloat4& o, const vfloat4& d) : tnear(max(ray.tnear(), 0.0f)) {
    const PlaneFactors factors(d);
    org = components(o);
    near = components(factors.near);
    far = components(factors.far);
    const size_t negativeAxes = size_t(movemask(factors.rdir < vfloat4(zero)));
    for (size_t axis = 0; axis < 3; axis++) nearPlane[axis] = 2 * axis + ((negativeAxes >> axis) & 1u);
  }

  /*! Returns the mask of children that the ray intersects before tfar. distances: receives their entry distances. */
  __forceinline uint32_t intersect(const WideNode& node, float tfar, vfloatV distances[vectors]) const {
    return intersect(tfar, distances, [&](size_t plane, int j) { return planes(node, plane, j); });
  }

  typedef WideNode Node;

protected:
  /*! planesOf(plane,j): planes of the children in vector j. */
  template<typename PlanesOf>
  __forceinline uint32_t intersect(float tfar, vfloatV distances[vectors], const PlanesOf& planesOf) const {
    vboolV hit[vectors];
#pragma GCC unroll 4
    for (int j = 0; j < vectors; j++) {
      vfloatV from[3], to[3];
      for (size_t axis = 0; axis < 3; axis++) {
        from[axis] = (planesOf(nearPlane[axis], j) - org[axis]) * near[axis];
        to[axis] = (planesOf(nearPlane[axis] ^ 1u, j) - org[axis]) * far[axis];
      }
      distances[j] = max(max(from[0], from[1]), max(from[2], vfloatV(tnear)));
      hit[j] = distances[j] <= min(min(to[0], to[1]), min(to[2], vfloatV(tfar)));
    }
    return movemasks(hit);
  }

  static __forceinline Vec3vf<vectorWidth> components(const vfloat4& v) {
    return Vec3vf<vectorWidth>(broadcast<0>(v), broadcast<1>(v), broadcast<2>(v));
  }
  static __forceinline vfloatV planes(const WideNode& node, size_t plane, int j) {
    return vfloatV::load(node.planes[plane] + vectorWidth * j);
  }

  Vec3vf<vectorWidth> org, near, far;
  size_t nearPlane[3];
  const float tnear;
};

/*! In the tree of moving surfaces, at the ray's time. */
class MovingWideRay : public WideRay {
public:
  typedef WideMovingNode Node;

  __forceinline MovingWideRay(const Ray& ray, const vfloat4& o, const vfloat4& d)
    : WideRay(ray, o, d),
      time(ray.time()) {}

  __forceinline uint32_t intersect(const WideMovingNode& node, float tfar, vfloatV distances[vectors]) const {
    return WideRay::intersect(tfar, distances, [&](size_t plane, int j) {
      return madd(time, vfloatV::load(node.differences[plane] + vectorWidth * j), planes(node, plane, j));
    });
  }

private:
  const vfloatV time;
};

/*! A node on the stack. */
struct WideEntry {
  size_t ref;
  float distance;
};

/*! Begins to load a node, or the header and the boxes of a block. */
static __forceinline void prefetch(size_t ref) {
  const char* const address = (const char*)(ref & ~size_t(15));
  for (int line = 0; line < 4; line++) prefetchL1(address + 64 * line);
}

static const size_t wideStackSize = 1 + (wideChildren - 1) * BVH4::maxDepth;

/*! Finds the closest hit of a ray. RayInTree: WideRay or MovingWideRay. intersect(ref): intersects a leaf. */
template<typename RayInTree, typename Intersect>
__forceinline void traverseClosestHit(const typename RayInTree::Node* root, RayHit& ray, Intersect& intersect) {
  const vfloat4 org = loadOfRay(&ray.org.x), dir = loadOfRay(&ray.dir.x);
  if (unlikely(!isValidRay(ray, org, dir))) return;
  const RayInTree wideRay(ray, org, dir);
  WideEntry stack[wideStackSize];
  WideEntry* top = stack;
  BVH4::NodeRef cur = size_t(root);
  while (true) {
    bool isMissed = false;
    while (!cur.isLeaf()) {
      const typename RayInTree::Node& node = *(const typename RayInTree::Node*)size_t(cur);
      vfloatV distances[WideRay::vectors];
      uint32_t mask = wideRay.intersect(node, max(ray.tfar, 0.0f), distances);
      isMissed = mask == 0;
      if (unlikely(isMissed)) break;
      uint32_t i = uint32_t(bsf(mask));
      size_t nearest = node.children[i];
      cur = nearest;
      mask &= mask - 1;
      if (likely(mask == 0)) continue;
      alignas(64) float at[wideChildren];
      for (int j = 0; j < WideRay::vectors; j++) vfloatV::store(at + vectorWidth * j, distances[j]);
      float nearestDistance = at[i];
      WideEntry* const first = top;
      for (; mask; mask &= mask - 1) {
        i = uint32_t(bsf(mask));
        WideEntry entry = {node.children[i], at[i]};
        if (entry.distance < nearestDistance) {
          std::swap(entry.ref, nearest);
          std::swap(entry.distance, nearestDistance);
        }
        WideEntry* place = top++;
        for (; place != first && place[-1].distance < entry.distance; place--) place[0] = place[-1];
        *place = entry;
        prefetch(entry.ref);
      }
      cur = nearest;
    }
    if (likely(!isMissed)) intersect(cur);
    do {
      if (top == stack) return;
      top--;
    } while (top->distance > ray.tfar);
    cur = top->ref;
  }
}

/*! Returns true if the ray has a hit. isHit(ref): returns true if a leaf has one. */
template<typename RayInTree, typename IsHit>
__forceinline bool traverseAnyHit(const typename RayInTree::Node* root, Ray& ray, IsHit& isHit) {
  const vfloat4 org = loadOfRay(&ray.org.x), dir = loadOfRay(&ray.dir.x);
  // tfar < 0: Embree's mark of an any-hit ray that has found a hit
  if (unlikely(ray.tfar < 0.0f || !isValidRay(ray, org, dir))) return false;
  const RayInTree wideRay(ray, org, dir);
  size_t stack[wideStackSize];
  size_t* top = stack;
  *top++ = size_t(root);
  while (top != stack) {
    const BVH4::NodeRef cur = *--top;
    if (cur.isLeaf()) {
      if (isHit(cur)) return true;
      continue;
    }
    const typename RayInTree::Node& node = *(const typename RayInTree::Node*)size_t(cur);
    vfloatV distances[WideRay::vectors];
    for (uint32_t mask = wideRay.intersect(node, max(ray.tfar, 0.0f), distances); mask; mask &= mask - 1)
      *top++ = node.children[bsf(mask)];
  }
  return false;
}
} // namespace embree::isa::cbvh
