// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's BVH4 traversal of single rays over blocks and grids. A leaf of the top-level BVH says by its
 * type what it refers to. */

#include "../../bvh/bvh_intersector1.cpp"
#include "kind_visitors1.h"

namespace embree
{
  namespace isa
  {
    struct CompressedSubdivIntersector1
    {
      typedef void Primitive;

      struct Precalculations : public SubdivPatch1Intersector1::Precalculations
      {
        __forceinline Precalculations (const Ray& ray, const void* ptr)
          : SubdivPatch1Intersector1::Precalculations(ray,ptr) {}

        cbvh::RayPrecalculations block;
        cbvh::VertRay vert;
      };

      template<int N, bool robust>
      static __forceinline void intersect (const Accel::Intersectors* This, Precalculations& pre, RayHit& ray, IntersectContext* context,
                                           const Primitive* prim, size_t type, const TravRay<N,robust>& tray, size_t& lazyNode)
      {
        bool found;
        if (!cbvh::intersectBlock(type,ray,context,pre.block,pre.vert,prim,found))
          SubdivPatch1Intersector1::intersect(This,pre,ray,context,(const GridSOA*)prim,type,tray,lazyNode);
      }

      template<int N, bool robust>
      static __forceinline bool occluded (const Accel::Intersectors* This, Precalculations& pre, Ray& ray, IntersectContext* context,
                                          const Primitive* prim, size_t type, const TravRay<N,robust>& tray, size_t& lazyNode)
      {
        bool found;
        if (cbvh::intersectBlock(type,ray,context,pre.block,pre.vert,prim,found)) return found;
        return SubdivPatch1Intersector1::occluded(This,pre,ray,context,(const GridSOA*)prim,type,tray,lazyNode);
      }

      /*! point queries do not see subdivision surfaces, as in Embree */
      template<int N>
      static __forceinline bool pointQuery (const Accel::Intersectors*, PointQuery*, PointQueryContext*, const Primitive*, size_t, const TravPointQuery<N>&, size_t&) {
        return false;
      }
    };

    typedef BVHNIntersector1<4,BVH_AN1,true,CompressedSubdivIntersector1> CompressedSubdivTraversal1;
  }
}
