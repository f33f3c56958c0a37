// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Intersector of blocks of cVERT for the rays of a packet, one by one: what one of them has had decoded serves
 * the others (vert_cache.h). */

#include "vert_intersector1.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      template<int K>
      class VertIntersectorK
      {
      public:
        __forceinline VertIntersectorK () : loaded(0) {}

        /*! which rays of a mask accepted a hit */
        template<typename Rays>
        __noinline uint32_t intersect (uint32_t mask, Rays& rays, IntersectContext* context, const VertHeader* block)
        {
          uint32_t found = 0;
          for (uint32_t rest=mask; rest; rest&=rest-1)
          {
            const uint32_t k = uint32_t(bsf(rest));
            auto& ray = single(rays,k);
            if (!intersect1(ray,context,vert[k],block)) continue;
            found |= 1u << k;
            store(rays,k,ray);
          }
          return found;
        }

      private:
        template<typename RayType>
        static __forceinline bool intersect1 (RayType& ray, IntersectContext* context, VertRay& vert, const VertHeader* block) {
          return VertIntersector1<RayType>::intersect(ray,context,vert,block);
        }

        __forceinline RayHit& single (const RayHitK<K>& rays, uint32_t k) { return load<RayHit>(rays,k); }
        __forceinline Ray& single (const RayK<K>& rays, uint32_t k) { return load<Ray>(rays,k); }

        static __forceinline void store (RayHitK<K>& rays, uint32_t k, const RayHit& ray) { rays.set(k,ray); }
        static __forceinline void store (RayK<K>&, uint32_t, const Ray&) {} // the traversal does

        template<typename RayType, typename Rays>
        __forceinline RayType& load (const Rays& rays, uint32_t k)
        {
          RayType& ray = (RayType&)ray1[k];
          if (likely((loaded >> k) & 1)) ray.tfar = rays.tfar[k];
          else {
            loaded |= 1u << k;
            rays.get(k,ray);
          }
          return ray;
        }

        uint32_t loaded;  //!< rays that have met a block
        RayHit ray1[K];
        VertRay vert[K];
      };
    }
  }
}
