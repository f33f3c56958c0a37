// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray queries of the top-level BVH4 that Embree calls for scenes with compressed geometries: one class for the
 * tree of surfaces at rest, one for the tree of moving surfaces. Leaves are blocks (leaf_intersectors1.h), or Embree's
 * grids for patches that are not compressed. */

#include "top_level1.h"
#include "leaf_intersectors1.h"
#include "point_query.h"

namespace embree::isa {
/*! Intersects leaves: blocks, and grids by Embree's intersector. */
struct CompressedSubdivIntersector1 {
  typedef void Primitive;

  struct State : public SubdivPatch1Intersector1::Precalculations {
    __forceinline State(const Ray& ray, const void* ptr)
      : SubdivPatch1Intersector1::Precalculations(ray, ptr),
        framed(ray.tfar) {}

    cbvh::FramedRay framed;
    cbvh::VertRay vert;
  };

  template<int N, bool robust>
  static __forceinline void intersect(const Accel::Intersectors* This, State& state, RayHit& ray,
                                      IntersectContext* context, const Primitive* prim, size_t type,
                                      const TravRay<N, robust>& tray, size_t& lazyNode) {
    bool found;
    if (!cbvh::intersectBlock(type, ray, context, state.framed, state.vert, prim, found))
      SubdivPatch1Intersector1::intersect(This, state, ray, context, (const GridSOA*)prim, type, tray, lazyNode);
  }

  template<int N, bool robust>
  static __forceinline bool occluded(const Accel::Intersectors* This, State& state, Ray& ray, IntersectContext* context,
                                     const Primitive* prim, size_t type, const TravRay<N, robust>& tray,
                                     size_t& lazyNode) {
    bool found;
    if (cbvh::intersectBlock(type, ray, context, state.framed, state.vert, prim, found)) return found;
    return SubdivPatch1Intersector1::occluded(This, state, ray, context, (const GridSOA*)prim, type, tray, lazyNode);
  }
};

/*! Queries of the tree of surfaces at rest. */
struct CompressedSubdivTraversal1 {
  static void intersect(const Accel::Intersectors* This, RayHit& ray, IntersectContext* context) {
    const BVH4* bvh = (const BVH4*)This->ptr;
    if (bvh->root == BVH4::emptyNode || unlikely(!cbvh::isValidRay(ray))) return;
    // filter functions must see hits in order, see traverseClosestHit1
    const bool isFiltered = context->hasContextFilter() || context->scene->hasGeometryFilterFunction();
    LeafIntersector leaves = {This, ray, context, CompressedSubdivIntersector1::State(ray, bvh), isFiltered};
    cbvh::traverseClosestHit1(bvh->root, cbvh::StaticNodes(), ray, leaves);
    ray.tfar = leaves.state.framed.finalTfar(ray.tfar);
  }

  static void occluded(const Accel::Intersectors* This, Ray& ray, IntersectContext* context) {
    const BVH4* bvh = (const BVH4*)This->ptr;
    // tfar < 0: Embree's mark of an any-hit ray that has found a hit
    if (bvh->root == BVH4::emptyNode || unlikely(ray.tfar < 0.0f || !cbvh::isValidRay(ray))) return;
    CompressedSubdivIntersector1::State state(ray, bvh);
    const bool isOccluded = cbvh::traverseAnyHit1(
        bvh->root, cbvh::StaticNodes(), ray, [&](BVH4::NodeRef leaf, const TravRay<4, true>& tray, size_t& lazyNode) {
          size_t type;
          const void* prim = leaf.leaf(type);
          return CompressedSubdivIntersector1::occluded(This, state, ray, context, prim, type, tray, lazyNode);
        });
    if (isOccluded) ray.tfar = neg_inf;
  }

  static bool pointQuery(const Accel::Intersectors* This, PointQuery* query, PointQueryContext* context) {
    return cbvh::queryPoint((const BVH4*)This->ptr, query, context);
  }

private:
  /*! The LeafIntersector of traverseClosestHit1. */
  struct LeafIntersector {
    const Accel::Intersectors* This;
    RayHit& ray;
    IntersectContext* context;
    CompressedSubdivIntersector1::State state;
    bool isSorted;

    static __forceinline bool hasFrame(BVH4::NodeRef leaf) {
      size_t type;
      leaf.leaf(type);
      return cbvh::FramedRay::isFramed(type);
    }

    __forceinline void setEntryT(float t) { state.framed.setEntryT(t); }

    __forceinline void intersect(BVH4::NodeRef leaf, const TravRay<4, true>& tray, size_t& lazyNode) {
      size_t type;
      const void* prim = leaf.leaf(type);
      CompressedSubdivIntersector1::intersect(This, state, ray, context, prim, type, tray, lazyNode);
    }
  };
};

/*! Queries of the tree of moving surfaces. */
struct CompressedMotionTraversal1 {
  static void intersect(const Accel::Intersectors* This, RayHit& ray, IntersectContext* context) {
    const BVH4* bvh = (const BVH4*)This->ptr;
    if (cbvh::isValidRay(ray) && cbvh::mayIntersect(ray, boundsAtAllTimes(bvh))) intersectTree(bvh, ray, context);
  }

  static void occluded(const Accel::Intersectors* This, Ray& ray, IntersectContext* context) {
    const BVH4* bvh = (const BVH4*)This->ptr;
    // tfar < 0: see above
    if (!(ray.tfar < 0.0f) && cbvh::isValidRay(ray) && cbvh::mayIntersect(ray, boundsAtAllTimes(bvh)))
      occludedTree(bvh, ray, context);
  }

  static __forceinline BBox3fa boundsAtAllTimes(const BVH4* bvh) {
    return merge(bvh->bounds.bounds0, bvh->bounds.bounds1);
  }

  /* For callers that have tested the ray and the bounds. */
  static __noinline void intersectTree(const BVH4* bvh, RayHit& ray, IntersectContext* context) {
    LeafIntersector leaves = {ray, context};
    cbvh::traverseClosestHit1(bvh->root, cbvh::MovingNodes{ray.time()}, ray, leaves);
  }
  static __noinline void occludedTree(const BVH4* bvh, Ray& ray, IntersectContext* context) {
    cbvh::VertRay vertRay;
    const bool isOccluded = cbvh::traverseAnyHit1(bvh->root, cbvh::MovingNodes{ray.time()}, ray,
                                                  [&](BVH4::NodeRef leaf, const TravRay<4, true>&, size_t&) {
                                                    return intersectLeaf(leaf, ray, context, vertRay);
                                                  });
    if (isOccluded) ray.tfar = neg_inf;
  }

  static bool pointQuery(const Accel::Intersectors* This, PointQuery* query, PointQueryContext* context) {
    return cbvh::queryPoint((const BVH4*)This->ptr, query, context);
  }

private:
  template<typename RayType>
  static __forceinline bool intersectLeaf(BVH4::NodeRef leaf, RayType& ray, IntersectContext* context,
                                          cbvh::VertRay& vertRay) {
    size_t type;
    const void* const block = leaf.leaf(type);
    return cbvh::intersectMovingBlock(type, ray, context, vertRay, block);
  }

  /*! The LeafIntersector of traverseClosestHit1. Moving blocks have no frames. */
  struct LeafIntersector {
    RayHit& ray;
    IntersectContext* context;
    cbvh::VertRay vertRay;
    static const bool isSorted = false;

    static __forceinline bool hasFrame(BVH4::NodeRef) { return false; }
    __forceinline void setEntryT(float) {}
    __forceinline void intersect(BVH4::NodeRef leaf, const TravRay<4, true>&, size_t&) {
      intersectLeaf(leaf, ray, context, vertRay);
    }
  };
};
} // namespace embree::isa
