// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* intersector1.cpp for the tree of moving surfaces. */

#include "queries1.h"
#include "top_level1.h"
#include "../base/leaf_type.h"
#include "../exact/moving_intersector1.h"

namespace embree::isa {
namespace cbvh {
/*! Leaves of the trees of moving surfaces. */
class MovingLeaves {
  typedef TravRay<4, true> Tray;

public:
  __forceinline explicit MovingLeaves(IntersectContext* context) : context(context) {}

  __forceinline StackEntry* intersect(RayHit& ray, const ReachedLeaf& leaf, const Tray&, StackEntry*, StackEntry* top) {
    intersectBlock(ray, leaf.ref);
    return top;
  }

  __forceinline bool isOccluded(Ray& ray, BVH4::NodeRef leaf, const Tray&, BVH4::NodeRef*&) {
    return intersectBlock(ray, leaf);
  }

  /*! Returns true if a hit was accepted. */
  template<typename RayType>
  __forceinline bool intersectBlock(RayType& ray, BVH4::NodeRef leaf) {
    size_t type;
    const void* const prim = leaf.leaf(type);
    switch (BlockType(type)) {
    case VERT_BLOCK: return intersectMovingVert(ray, context, vert, (const VertHeader*)prim);
    case MESH_BLOCK: return intersectMovingMesh(ray, context, vert, prim);
    case TILE_BLOCK:
      return isMeshTile(prim) ? intersectMovingMeshTile(ray, context, vert, prim)
                              : intersectMovingTile(ray, context, vert, (const VertHeader*)prim);
    case FRAMED_BLOCK: break; // never moves
    }
    return false;
  }

private:
  IntersectContext* context;
  VertRay vert;
};

/*! Root of the tree of wide nodes, or null. */
static __forceinline const WideMovingNode* wideRoot(const BVH4* bvh) {
  const mvector<WideMovingNode>& nodes = ((const CompressedTree*)bvh)->wideMoving;
  return nodes.empty() ? nullptr : nodes.data();
}
} // namespace cbvh

void CompressedMotionTraversal1::intersect(const Accel::Intersectors* This, RayHit& ray, IntersectContext* context) {
  const BVH4* bvh = (const BVH4*)This->ptr;
  if (cbvh::isValidRay(ray) && cbvh::mayIntersect(ray, boundsAtAllTimes(bvh))) intersectTree(bvh, ray, context);
}

void CompressedMotionTraversal1::occluded(const Accel::Intersectors* This, Ray& ray, IntersectContext* context) {
  const BVH4* bvh = (const BVH4*)This->ptr;
  // tfar < 0: Embree's mark of an any-hit ray that has found a hit
  if (!(ray.tfar < 0.0f) && cbvh::isValidRay(ray) && cbvh::mayIntersect(ray, boundsAtAllTimes(bvh)))
    occludedTree(bvh, ray, context);
}

__noinline void CompressedMotionTraversal1::intersectTree(const BVH4* bvh, RayHit& ray, IntersectContext* context) {
  cbvh::MovingLeaves leaves(context);
  if (const WideMovingNode* root = cbvh::wideRoot(bvh)) {
    auto intersect = [&](BVH4::NodeRef leaf) { leaves.intersectBlock(ray, leaf); };
    return cbvh::traverseClosestHit<cbvh::MovingWideRay>(root, ray, intersect);
  }
  cbvh::traverseClosestHit1(bvh->root, cbvh::MovingNodes{ray.time()}, ray, leaves);
}

__noinline void CompressedMotionTraversal1::occludedTree(const BVH4* bvh, Ray& ray, IntersectContext* context) {
  cbvh::MovingLeaves leaves(context);
  if (const WideMovingNode* root = cbvh::wideRoot(bvh)) {
    auto isHit = [&](BVH4::NodeRef leaf) { return leaves.intersectBlock(ray, leaf); };
    if (cbvh::traverseAnyHit<cbvh::MovingWideRay>(root, ray, isHit)) ray.tfar = neg_inf;
    return;
  }
  if (cbvh::traverseAnyHit1(bvh->root, cbvh::MovingNodes{ray.time()}, ray, leaves)) ray.tfar = neg_inf;
}

DEFINE_INTERSECTOR1(BVH4CompressedMotionIntersector1, CompressedMotionTraversal1);
} // namespace embree::isa
