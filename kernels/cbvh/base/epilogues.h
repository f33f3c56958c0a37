// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reports hits through Embree's epilogues, the functors that apply masks and filter functions and then store a hit.
 * Compressed surfaces thus support them like all other geometries. Used by the intersectors of blocks (vert,
 * framed). */

#include "../embree/traversal.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! A hit in the form that Embree's epilogues of single rays require. Ng: need not be normalized. */
      struct SurfaceHit1
      {
        float u, v, t;
        Vec3fa Ng;
        __forceinline void finalize () {}
      };

      /*! Geometry ID of a surface number in the scene of the query, see surface_ids.h. */
      __forceinline uint32_t geomIDOf (const IntersectContext* context, uint32_t surface) {
        return context->scene->surfaceIDs[surface];
      }

      /*! Reports a hit of a single ray. surface: surface number. Returns false if the mask or a filter rejected it. */
      __forceinline bool report (RayHit& ray, IntersectContext* context, uint32_t surface, uint32_t primID,
                                 SurfaceHit1& hit) {
        return Intersect1Epilog1<true>(ray,context,geomIDOf(context,surface),primID)(hit);
      }
      __forceinline bool report (Ray& ray, IntersectContext* context, uint32_t surface, uint32_t primID,
                                 SurfaceHit1& hit) {
        return Occluded1Epilog1<true>(ray,context,geomIDOf(context,surface),primID)(hit);
      }

      /*! Reports a hit of ray k of a packet. Returns false if the mask or a filter rejected it. */
      template<int K>
      __forceinline bool report (RayHitK<K>& rays, size_t k, IntersectContext* context, uint32_t surface,
                                 uint32_t primID, SurfaceHit1& hit) {
        return Intersect1KEpilog1<K,true>(rays,k,context,geomIDOf(context,surface),primID)(hit);
      }
      template<int K>
      __forceinline bool report (RayK<K>& rays, size_t k, IntersectContext* context, uint32_t surface,
                                 uint32_t primID, SurfaceHit1& hit) {
        return Occluded1KEpilog1<K,true>(rays,k,context,geomIDOf(context,surface),primID)(hit);
      }

      /*! Reports one hit for each of the rays `lanes`. Returns the rays whose hit was accepted. hit: functor with the
       *  signature that Embree's epilogues of packets require; computes u, v, t and Ng. */
      template<int K, typename Hit>
      __forceinline vbool<K> report (RayHitK<K>& rays, const vbool<K>& lanes, IntersectContext* context,
                                     uint32_t surface, uint32_t primID, const Hit& hit) {
        return IntersectKEpilogMU<1,K,true>(rays,context,geomIDOf(context,surface),primID)(lanes,hit);
      }
      template<int K, typename Hit>
      __forceinline vbool<K> report (RayK<K>& rays, const vbool<K>& lanes, IntersectContext* context,
                                     uint32_t surface, uint32_t primID, const Hit& hit) {
        vbool<K> remaining = lanes; // Embree removes rays that hit; callers use the returned rays instead
        return OccludedKEpilogMU<1,K,true>(remaining,rays,context,geomIDOf(context,surface),primID)(lanes,hit);
      }

      /*! True for the ray types of any-hit queries. */
      template<typename Rays> struct IsAnyHit;
      template<int K> struct IsAnyHit<RayK<K>>    { static const bool value = true; };
      template<int K> struct IsAnyHit<RayHitK<K>> { static const bool value = false; };

      /*! Returns false if callers need not compute u, v and Ng of a hit, because nothing reads them: an any-hit query
       *  passes them to filter functions only. */
      template<typename Rays>
      __forceinline bool needsHitData (const Rays&, const IntersectContext*, uint32_t) { return true; }
      template<int K>
      __forceinline bool needsHitData (const RayK<K>&, const IntersectContext* context, uint32_t surface) {
        return unlikely(context->hasContextFilter()
                        || context->scene->get(geomIDOf(context,surface))->hasOcclusionFilter());
      }
    }
  }
}
