// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Traversal of the top-level BVH by packets. The rays' frustum culls nodes, as in Embree's coherent traversal. Like
 * single rays, a ray visits only blocks whose bounds it intersects itself: blocks with frames can be hit outside of
 * their bounds (paper/block_bounds.h). */

#include "top_level_ray.h"
#include "../embree/traversal.h"

namespace embree::isa::cbvh {
/*! LeafIntersector: a class for closest hit or any hit with
 *
 *     void intersect (const vbool<K>& valid, BVH4::NodeRef leaf, const vfloat<K>& entryT, const Tray& tray,
 *                     size_t& lazyNode)
 *       Intersects a leaf. entryT: entry distances of the rays in `valid`. lazyNode: receives a node that must be
 *       traversed next.
 *     vfloat<K> tfar
 *       Ends of rays, -inf for any-hit rays with a hit; read after each intersect(). */
template<int K, typename LeafIntersector>
class PacketTraversal {
  typedef BVH4::NodeRef NodeRef;
  typedef TravRayK<K, true> Tray;

  /*! Stack entry. entryT: entry distance of each ray; NaN if it misses the node. */
  struct Entry {
    vfloat<K> entryT;
    NodeRef node;
    float frustumEntryT; //!< of the frustum, for sorting: a lower bound of `entryT`
  };

public:
  /*! Traverses the tree with the rays in `valid`, which must have the same signs of tray.rdir. k: one of them.
   *  Sets tnear and tfar of tray. */
  static __noinline void run(const vbool<K>& valid, size_t k, NodeRef root, RayK<K>& rays, Tray& tray,
                             LeafIntersector& leaves) {
    tray.tnear = select(valid, max(vfloat<K>(rays.tnear()), vfloat<K>(zero)), vfloat<K>(pos_inf));
    tray.tfar = select(valid, max(vfloat<K>(rays.tfar), vfloat<K>(zero)), vfloat<K>(neg_inf));
    Frustum<true> frustum;
    frustum.template init<K>(valid, tray.org, tray.rdir, tray.tnear, tray.tfar, 4);
    /* With the factors of BoxTest, the frustum culls no box that a ray enters: rounding is monotonic, so its
     * distances bound each ray's in floats too. Embree's test alone has 2 ulps. */
    frustum.min_rdir = Vec3fa(nearFactor) * frustum.min_rdir;
    frustum.max_rdir = Vec3fa(farFactor) * frustum.max_rdir;

    const BoxTest boxTest(tray, k);

    Entry stack[1 + 3 * BVH4::maxDepth + 1];
    Entry* top = stack;
    *top++ = Entry{tray.tnear, root, float(neg_inf)};
    while (top != stack) {
      const Entry entry = *--top;
      const vbool<K> hit = entry.entryT <= tray.tfar;
      if (none(hit)) continue;
      if (!entry.node.isLeaf()) {
        top = pushChildren(entry, frustum, boxTest, tray, top);
        continue;
      }
      size_t lazyNode = 0;
      leaves.intersect(hit, entry.node, entry.entryT, tray, lazyNode);
      if (any(leaves.tfar < tray.tfar)) {
        // NaN in inactive lanes would spoil the frustum's maximum
        tray.tfar = select(valid, min(tray.tfar, leaves.tfar), tray.tfar);
        frustum.template updateMaxDist<K>(tray.tfar);
      }
      if (unlikely(lazyNode)) *top++ = Entry{entry.entryT, NodeRef(lazyNode), entry.frustumEntryT};
    }
  }

private:
  /*! Embree's robust box test for packets: the operations of single rays, with the factors of PlaneFactors. */
  class BoxTest {
    vfloat<K> rdirNear[3], rdirFar[3];
    size_t nearSide[3];

  public:
    __forceinline BoxTest(const Tray& tray, size_t k) {
      for (int axis = 0; axis < 3; axis++) {
        rdirNear[axis] = vfloat<K>(nearFactor) * tray.rdir[axis];
        rdirFar[axis] = vfloat<K>(farFactor) * tray.rdir[axis];
        nearSide[axis] = tray.rdir[axis][k] >= 0.0f ? 0 : 1;
      }
    }

    __forceinline vbool<K> intersectBox(const BVH4::AABBNode* node, size_t i, const Tray& tray,
                                        vfloat<K>& entryT) const {
      const vfloat4* planes = &node->lower_x; // lower and upper planes, axis by axis
      vfloat<K> exitT = tray.tfar;
      entryT = tray.tnear;
      for (int axis = 0; axis < 3; axis++) {
        entryT = max(entryT, (vfloat<K>(planes[2 * axis + nearSide[axis]][i]) - tray.org[axis]) * rdirNear[axis]);
        exitT = min(exitT, (vfloat<K>(planes[2 * axis + 1 - nearSide[axis]][i]) - tray.org[axis]) * rdirFar[axis]);
      }
      return entryT <= exitT;
    }
  };

  /*! Pushes the children that rays intersect, the nearest one last. Returns the new top. */
  static __forceinline Entry* pushChildren(const Entry& entry, const Frustum<true>& frustum, const BoxTest& boxTest,
                                           const Tray& tray, Entry* top) {
    const BVH4::AABBNode* node = entry.node.getAABBNode();
    vfloat4 frustumEntryT;
    Entry* const bottom = top;
    for (size_t rest = intersectNodeFrustum<4>(node, frustum, frustumEntryT); rest;) {
      const size_t i = bscf(rest);
      vfloat<K> entryT;
      const vbool<K> hit = boxTest.intersectBox(node, i, tray, entryT);
      if (none(hit)) continue;
      BVH4::prefetch(node->child(i));
      const Entry child = {select(hit, entryT, vfloat<K>(nan)), node->child(i), frustumEntryT[i]};
      Entry* slot = top++;
      for (; slot != bottom && slot[-1].frustumEntryT < child.frustumEntryT; slot--) slot[0] = slot[-1];
      *slot = child;
    }
    return top;
  }
};
} // namespace embree::isa::cbvh
