// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* BVH4 traversal of single rays over blocks that move. Rays are tested first against a box that holds all of them at all times, so that a scene's
 * still surfaces lose little by others that move elsewhere. */

#include "point_query.h"
#include "top_level1.h"
#include "../vert/intersector1.h"

namespace embree
{
  namespace isa
  {
    struct CompressedMotionTraversal1
    {
      static void intersect (const Accel::Intersectors* This, RayHit& ray, IntersectContext* context)
      {
        const BVH4* bvh = (const BVH4*)This->ptr;
        if (cbvh::mayHit(ray) && cbvh::mayMeet(ray,boxOf(bvh))) intersectTree(bvh,ray,context);
      }

      static void occluded (const Accel::Intersectors* This, Ray& ray, IntersectContext* context)
      {
        const BVH4* bvh = (const BVH4*)This->ptr;
        if (!(ray.tfar < 0.0f) && cbvh::mayHit(ray) && cbvh::mayMeet(ray,boxOf(bvh))) occludedTree(bvh,ray,context); // before 0: it has ended
      }

      /*! Of all blocks at all times, or empty. */
      static __forceinline BBox3fa boxOf (const BVH4* bvh) { return merge(bvh->bounds.bounds0,bvh->bounds.bounds1); }

      /*! What is behind these tests. */
      static __noinline void intersectTree (const BVH4* bvh, RayHit& ray, IntersectContext* context)
      {
        Leaves leaves = { ray,context };
        cbvh::traverseClosestHit1(bvh->root,cbvh::MovingNodes{ ray.time() },ray,leaves);
      }
      static __noinline void occludedTree (const BVH4* bvh, Ray& ray, IntersectContext* context)
      {
        cbvh::VertRay vertRay;
        const bool isOccluded = cbvh::traverseAnyHit1(bvh->root,cbvh::MovingNodes{ ray.time() },ray,[&](BVH4::NodeRef leaf, const TravRay<4,true>&, size_t&) {
            return cbvh::intersectMovingVert(ray,context,vertRay,blockOf(leaf));
          });
        if (isOccluded) ray.tfar = neg_inf;
      }

      static bool pointQuery (const Accel::Intersectors* This, PointQuery* query, PointQueryContext* context) {
        return cbvh::queryPoint((const BVH4*)This->ptr,query,context);
      }

    private:
      static __forceinline const cbvh::VertHeader* blockOf (BVH4::NodeRef leaf)
      {
        size_t type;
        return (const cbvh::VertHeader*)leaf.leaf(type);
      }

      struct Leaves
      {
        RayHit& ray;
        IntersectContext* context;
        cbvh::VertRay vertRay;
        static const bool isSorted = false;

        static __forceinline bool hasFrame (BVH4::NodeRef) { return false; }
        __forceinline void setEnter (float) {}
        __forceinline void intersect (BVH4::NodeRef leaf, const TravRay<4,true>&, size_t&) { cbvh::intersectMovingVert(ray,context,vertRay,blockOf(leaf)); }
      };
    };
  }
}
