// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Instantiation, for one ISA, of Embree's BVH4 traversal over blocks and grids.
 * A leaf of the top-level BVH says by its type what it refers to. */

#include "../../bvh/bvh_intersector1.cpp"
#include "../../bvh/bvh_intersector_stream.h"
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

    /*! packets are traced ray by ray */
    template<int K>
    struct CompressedSubdivTraversalK
    {
      static void intersect (vint<K>* valid, Accel::Intersectors* This, RayHitK<K>& rays, IntersectContext* context)
      {
        for (size_t k=0; k<K; k++) {
          if ((*valid)[k] == 0) continue;
          RayHit ray;
          rays.get(k,ray);
          if (!(ray.tnear() <= ray.tfar)) continue; // inactive, as in Embree's packet traversal
          CompressedSubdivTraversal1::intersect(This,ray,context);
          rays.set(k,ray);
        }
      }

      static void occluded (vint<K>* valid, Accel::Intersectors* This, RayK<K>& rays, IntersectContext* context)
      {
        for (size_t k=0; k<K; k++) {
          if ((*valid)[k] == 0) continue;
          Ray ray;
          rays.get(k,ray);
          if (!(ray.tnear() <= ray.tfar)) continue;
          CompressedSubdivTraversal1::occluded(This,ray,context);
          rays.tfar[k] = ray.tfar;
        }
      }
    };

    DEFINE_INTERSECTOR1(BVH4CompressedSubdivIntersector1,CompressedSubdivTraversal1);
#if defined(EMBREE_RAY_PACKETS)
    DEFINE_INTERSECTOR4(BVH4CompressedSubdivIntersector4,CompressedSubdivTraversalK<4>);
#if defined(__AVX__)
    DEFINE_INTERSECTOR8(BVH4CompressedSubdivIntersector8,CompressedSubdivTraversalK<8>);
#endif
#if defined(__AVX512F__)
    DEFINE_INTERSECTOR16(BVH4CompressedSubdivIntersector16,CompressedSubdivTraversalK<16>);
#endif
    /* streams: Embree's own fallback, which hands over packets */
    DEFINE_INTERSECTORN(BVH4CompressedSubdivIntersectorN,BVHNIntersectorStreamPacketFallback<4>);
#endif
  }
}
