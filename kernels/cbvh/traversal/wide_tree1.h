// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray traversal of trees with wide nodes (blocks/wide_tree.h). Boxes are tested by the operations of Embree's
 * robust traversal, with the rays of top_level_ray.h. */

#include "top_level_ray.h"
#include "../blocks/wide_tree.h"

namespace embree::isa::cbvh {
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
    vboolV hit[vectors];
#pragma GCC unroll 4
    for (int j = 0; j < vectors; j++) {
      vfloatV from[3], to[3];
      for (size_t axis = 0; axis < 3; axis++) {
        from[axis] = (planes(node, nearPlane[axis], j) - org[axis]) * near[axis];
        to[axis] = (planes(node, nearPlane[axis] ^ 1u, j) - org[axis]) * far[axis];
      }
      distances[j] = max(max(from[0], from[1]), max(from[2], vfloatV(tnear)));
      hit[j] = distances[j] <= min(min(to[0], to[1]), min(to[2], vfloatV(tfar)));
    }
    return movemasks(hit);
  }

private:
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

/*! Finds the closest hit of a ray. intersect(ref): intersects a leaf. */
template<typename Intersect>
__forceinline void traverseClosestHit(const WideNode* root, RayHit& ray, Intersect& intersect) {
  const vfloat4 org = loadOfRay(&ray.org.x), dir = loadOfRay(&ray.dir.x);
  if (unlikely(!isValidRay(ray, org, dir))) return;
  const WideRay wideRay(ray, org, dir);
  WideEntry stack[wideStackSize];
  WideEntry* top = stack;
  BVH4::NodeRef cur = size_t(root);
  while (true) {
    bool isMissed = false;
    while (!cur.isLeaf()) {
      const WideNode& node = *(const WideNode*)size_t(cur);
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
template<typename IsHit>
__forceinline bool traverseAnyHit(const WideNode* root, Ray& ray, IsHit& isHit) {
  const vfloat4 org = loadOfRay(&ray.org.x), dir = loadOfRay(&ray.dir.x);
  // tfar < 0: Embree's mark of an any-hit ray that has found a hit
  if (unlikely(ray.tfar < 0.0f || !isValidRay(ray, org, dir))) return false;
  const WideRay wideRay(ray, org, dir);
  size_t stack[wideStackSize];
  size_t* top = stack;
  *top++ = size_t(root);
  while (top != stack) {
    const BVH4::NodeRef cur = *--top;
    if (cur.isLeaf()) {
      if (isHit(cur)) return true;
      continue;
    }
    const WideNode& node = *(const WideNode*)size_t(cur);
    vfloatV distances[WideRay::vectors];
    for (uint32_t mask = wideRay.intersect(node, max(ray.tfar, 0.0f), distances); mask; mask &= mask - 1)
      *top++ = node.children[bsf(mask)];
  }
  return false;
}
} // namespace embree::isa::cbvh
