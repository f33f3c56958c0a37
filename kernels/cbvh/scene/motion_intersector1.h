// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* BVH4 traversal of single rays over blocks that move. */

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
        if (bvh->root == BVH4::emptyNode || unlikely(!cbvh::mayHit(ray))) return;
        Leaves leaves = { ray,context };
        cbvh::traverseClosestHit1(bvh->root,cbvh::MovingNodes{ ray.time() },ray,leaves);
      }

      static void occluded (const Accel::Intersectors* This, Ray& ray, IntersectContext* context)
      {
        const BVH4* bvh = (const BVH4*)This->ptr;
        if (bvh->root == BVH4::emptyNode || unlikely(ray.tfar < 0.0f || !cbvh::mayHit(ray))) return; // before 0: it has ended
        cbvh::VertRay vertRay;
        const bool isOccluded = cbvh::traverseAnyHit1(bvh->root,cbvh::MovingNodes{ ray.time() },ray,[&](BVH4::NodeRef leaf, const TravRay<4,true>&, size_t&) {
            return cbvh::intersectMovingVert(ray,context,vertRay,blockOf(leaf));
          });
        if (isOccluded) ray.tfar = neg_inf;
      }

      static bool pointQuery (const Accel::Intersectors* This, PointQuery* query, PointQueryContext* context) {
        return cbvh::PointQueryTraversal(query,context)((const BVH4*)This->ptr);
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
