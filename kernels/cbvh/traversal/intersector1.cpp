// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Single-ray queries of the tree of surfaces at rest, compiled for one instruction set: the choice of a leaf's
 * intersector by the leaf's type. */

#include "queries1.h"
#include "top_level1.h"
#include "../base/leaf_type.h"
#include "../exact/intersector1.h"
#include "../paper/interface.h"

namespace embree::isa {
namespace cbvh {
/*! Leaves of the tree of surfaces at rest: blocks, and grids by Embree's intersector. */
class StaticLeaves {
  typedef SubdivPatch1Intersector1 Grids;
  typedef TravRay<4, true> Tray;

public:
  /*! isFiltered: filter functions must see hits in order, see FramedRay. */
  __forceinline StaticLeaves(const Accel::Intersectors* This, const Ray& ray, IntersectContext* context,
                             bool isFiltered)
    : This(This),
      context(context),
      grids(ray, This->ptr),
      framed(ray.tfar, isFiltered) {}

  /*! See traverseClosestHit1. */
  __forceinline StackEntry* intersect(RayHit& ray, const ReachedLeaf& leaf, const Tray& tray, StackEntry* stack,
                                      StackEntry* top) {
    size_t type;
    const void* const prim = leaf.ref.leaf(type);
    if (unlikely(!isBlock(type))) {
      size_t lazyNode = 0; // must be traversed next
      Grids::intersect(This, grids, ray, context, (const GridSOA*)prim, type, tray, lazyNode);
      return lazyNode ? push(top, BVH4::NodeRef(lazyNode), neg_inf) : top;
    }
    switch (BlockType(type)) {
    case VERT_BLOCK: intersectVert(ray, context, vert, (const VertHeader*)prim); break;
    case MESH_BLOCK: intersectMesh(ray, context, vert, prim); break;
    case FRAMED_BLOCK: return framed.intersect(ray, context, leaf.ref, leaf.entryT(), stack, top);
    }
    return top;
  }

  /*! See traverseAnyHit1. */
  __forceinline bool isOccluded(Ray& ray, BVH4::NodeRef leaf, const Tray& tray, BVH4::NodeRef*& top) {
    size_t type;
    const void* const prim = leaf.leaf(type);
    if (unlikely(!isBlock(type))) {
      size_t lazyNode = 0;
      if (Grids::occluded(This, grids, ray, context, (const GridSOA*)prim, type, tray, lazyNode)) return true;
      if (lazyNode) *top++ = BVH4::NodeRef(lazyNode);
      return false;
    }
    switch (BlockType(type)) {
    case VERT_BLOCK: return intersectVert(ray, context, vert, (const VertHeader*)prim);
    case MESH_BLOCK: return intersectMesh(ray, context, vert, prim);
    case FRAMED_BLOCK: return framed.occluded(ray, context, prim);
    }
    return false;
  }

  /*! The closest hit's distance, after the traversal. */
  __forceinline float finalTfar(float tfar) const { return framed.finalTfar(tfar); }

private:
  const Accel::Intersectors* This;
  IntersectContext* context;
  Grids::Precalculations grids;
  FramedRay framed;
  VertRay vert;
};
} // namespace cbvh

void CompressedSubdivTraversal1::intersect(const Accel::Intersectors* This, RayHit& ray, IntersectContext* context) {
  const BVH4* bvh = (const BVH4*)This->ptr;
  if (bvh->root == BVH4::emptyNode || unlikely(!cbvh::isValidRay(ray))) return;
  const bool isFiltered = context->hasContextFilter() || context->scene->hasGeometryFilterFunction();
  cbvh::StaticLeaves leaves(This, ray, context, isFiltered);
  cbvh::traverseClosestHit1(bvh->root, cbvh::StaticNodes(), ray, leaves);
  ray.tfar = leaves.finalTfar(ray.tfar);
}

void CompressedSubdivTraversal1::occluded(const Accel::Intersectors* This, Ray& ray, IntersectContext* context) {
  const BVH4* bvh = (const BVH4*)This->ptr;
  // tfar < 0: Embree's mark of an any-hit ray that has found a hit
  if (bvh->root == BVH4::emptyNode || unlikely(ray.tfar < 0.0f || !cbvh::isValidRay(ray))) return;
  cbvh::StaticLeaves leaves(This, ray, context, false);
  if (cbvh::traverseAnyHit1(bvh->root, cbvh::StaticNodes(), ray, leaves)) ray.tfar = neg_inf;
}

DEFINE_INTERSECTOR1(BVH4CompressedSubdivIntersector1, CompressedSubdivTraversal1);
} // namespace embree::isa
