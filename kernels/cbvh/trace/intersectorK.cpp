// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Packets and streams, instantiated for one ISA. Hits are those of single rays.
 *
 * Where all blocks are of cVERT, rays go down the top-level BVH together, by Embree's own traversal.
 * In a block each ray goes its own way; what one of them has had decoded serves the others (vert_cache.h).
 *
 * Scenes with blocks in frames are traced ray by ray: the walk through such a block is most of what a ray
 * costs, and nothing of it is shared. */

#include "../../bvh/bvh_intersector_hybrid.cpp"
#include "../../bvh/bvh_intersector_stream.h"
#include "compressed_intersector1.h"

namespace embree
{
  namespace isa
  {
    template<int K>
    struct RayByRay
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

    /*! blocks of cVERT, and GRID's own leaves where a face is not compressed */
    template<int K>
    struct VertIntersectorK
    {
      typedef void Primitive;
      typedef SubdivPatch1IntersectorK<K> Grids;

      /*! with the rays one by one, as far as they have met a block */
      struct Precalculations : public Grids::Precalculations
      {
        __forceinline Precalculations (const vbool<K>& valid, RayK<K>& rays)
          : Grids::Precalculations(valid,rays), loaded(0) {}

        template<typename RayType, typename Rays>
        __forceinline RayType& single (const Rays& rays, size_t k)
        {
          RayType& ray = (RayType&)ray1[k];
          if (likely((loaded >> k) & 1)) ray.tfar = rays.tfar[k];
          else {
            loaded |= 1u << k;
            rays.get(k,ray);
          }
          return ray;
        }

        uint32_t loaded;
        RayHit ray1[K];
        cbvh::VertRay vert[K];
      };

      template<bool robust>
      static __forceinline void intersect (const vbool<K>& valid, const Accel::Intersectors* This, Precalculations& pre, RayHitK<K>& rays, IntersectContext* context,
                                           const Primitive* prim, size_t type, const TravRayK<K,robust>& tray, size_t& lazyNode)
      {
        if (unlikely(!isBlock(type))) Grids::intersect(valid,This,pre,rays,context,(const GridSOA*)prim,type,tray,lazyNode);
        else traceTogether<RayHit>(movemask(valid),pre,rays,context,prim);
      }

      template<bool robust>
      static __forceinline vbool<K> occluded (const vbool<K>& valid, const Accel::Intersectors* This, Precalculations& pre, RayK<K>& rays, IntersectContext* context,
                                              const Primitive* prim, size_t type, const TravRayK<K,robust>& tray, size_t& lazyNode)
      {
        if (unlikely(!isBlock(type))) return Grids::occluded(valid,This,pre,rays,context,(const GridSOA*)prim,type,tray,lazyNode);
        vbool<K> found(false);
        /* Embree hands over all that are not occluded yet, also what has no range */
        for (size_t bits=traceTogether<Ray>(movemask(valid & (rays.tnear() <= rays.tfar)),pre,rays,context,prim); bits;) set(found,bscf(bits));
        return found;
      }

      template<int N, bool robust>
      static __forceinline void intersect (const Accel::Intersectors* This, Precalculations& pre, RayHitK<K>& rays, size_t k, IntersectContext* context,
                                           const Primitive* prim, size_t type, const TravRay<N,robust>& tray, size_t& lazyNode)
      {
        if (unlikely(!isBlock(type))) Grids::intersect(This,pre,rays,k,context,(const GridSOA*)prim,type,tray,lazyNode);
        else traceAlone<RayHit>(k,pre,rays,context,prim);
      }

      template<int N, bool robust>
      static __forceinline bool occluded (const Accel::Intersectors* This, Precalculations& pre, RayK<K>& rays, size_t k, IntersectContext* context,
                                          const Primitive* prim, size_t type, const TravRay<N,robust>& tray, size_t& lazyNode)
      {
        if (unlikely(!isBlock(type))) return Grids::occluded(This,pre,rays,k,context,(const GridSOA*)prim,type,tray,lazyNode);
        return traceAlone<Ray>(k,pre,rays,context,prim);
      }

    private:
      static __forceinline bool isBlock (size_t type) { return type >= cbvh::FIRST_BLOCK; }

      static __forceinline void store (RayHitK<K>& rays, size_t k, const RayHit& ray) { rays.set(k,ray); }
      static __forceinline void store (RayK<K>&, size_t, const Ray&) {} // the traversal does

      /*! one ray in a block; true if a hit was accepted */
      template<typename RayType, typename Rays>
      static __noinline bool traceAlone (size_t k, Precalculations& pre, Rays& rays, IntersectContext* context, const void* prim)
      {
        RayType& ray = pre.template single<RayType>(rays,k);
        const bool found = cbvh::VertIntersector1<RayType>::intersect(ray,context,pre.vert[k],(const cbvh::VertHeader*)prim);
        if (found) store(rays,k,ray);
        return found;
      }

      /*! rays of a mask in a block; which of them accepted a hit */
      template<typename RayType, typename Rays>
      static __noinline size_t traceTogether (size_t mask, Precalculations& pre, Rays& rays, IntersectContext* context, const void* prim)
      {
        size_t found = 0;
        while (mask) {
          const size_t k = bscf(mask);
          found |= size_t(traceAlone<RayType>(k,pre,rays,context,prim)) << k;
        }
        return found;
      }
    };

#if defined(EMBREE_RAY_PACKETS)
    DEFINE_INTERSECTOR4(BVH4CompressedSubdivIntersector4,RayByRay<4>);
    DEFINE_INTERSECTOR4(BVH4VertIntersector4,BVHNIntersectorKHybrid<4 COMMA 4 COMMA BVH_AN1 COMMA true COMMA VertIntersectorK<4> >);
#if defined(__AVX__)
    DEFINE_INTERSECTOR8(BVH4CompressedSubdivIntersector8,RayByRay<8>);
    DEFINE_INTERSECTOR8(BVH4VertIntersector8,BVHNIntersectorKHybrid<4 COMMA 8 COMMA BVH_AN1 COMMA true COMMA VertIntersectorK<8> >);
#endif
#if defined(__AVX512F__)
    DEFINE_INTERSECTOR16(BVH4CompressedSubdivIntersector16,RayByRay<16>);
    DEFINE_INTERSECTOR16(BVH4VertIntersector16,BVHNIntersectorKHybrid<4 COMMA 16 COMMA BVH_AN1 COMMA true COMMA VertIntersectorK<16> >);
#endif
    /* streams: Embree's own fallback, which hands over packets */
    DEFINE_INTERSECTORN(BVH4CompressedSubdivIntersectorN,BVHNIntersectorStreamPacketFallback<4>);
#endif
  }
}
