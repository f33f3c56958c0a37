// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reports hits through Embree's epilogues, which apply masks and filter functions and store the hit. For the
 * intersectors of blocks. */

#include "../embree/traversal.h"

namespace embree::isa::cbvh {
/*! A hit as Embree's epilogues of single rays require it. Ng need not be normalized. */
struct SurfaceHit1 {
  float u, v, t;
  Vec3fa Ng;
  __forceinline void finalize() {}
};

/*! Returns the ID of a surface (surface_ids.h) in the scene of the query. */
__forceinline uint32_t geomIDOf(const IntersectContext* context, uint32_t surfaceNumber) {
  return context->scene->surfaceIDs[surfaceNumber];
}

/*! Reports a hit of a single ray. Returns false if the mask or a filter rejected it. */
__forceinline bool report(RayHit& ray, IntersectContext* context, uint32_t surfaceNumber, uint32_t primID,
                          SurfaceHit1& hit) {
  return Intersect1Epilog1<true>(ray, context, geomIDOf(context, surfaceNumber), primID)(hit);
}
__forceinline bool report(Ray& ray, IntersectContext* context, uint32_t surfaceNumber, uint32_t primID,
                          SurfaceHit1& hit) {
  return Occluded1Epilog1<true>(ray, context, geomIDOf(context, surfaceNumber), primID)(hit);
}

/*! Same for ray k of a packet. */
template<int K>
__forceinline bool report(RayHitK<K>& rays, size_t k, IntersectContext* context, uint32_t surfaceNumber,
                          uint32_t primID, SurfaceHit1& hit) {
  return Intersect1KEpilog1<K, true>(rays, k, context, geomIDOf(context, surfaceNumber), primID)(hit);
}
template<int K>
__forceinline bool report(RayK<K>& rays, size_t k, IntersectContext* context, uint32_t surfaceNumber, uint32_t primID,
                          SurfaceHit1& hit) {
  return Occluded1KEpilog1<K, true>(rays, k, context, geomIDOf(context, surfaceNumber), primID)(hit);
}

/*! Reports one hit for each ray of the mask `lanes`. Returns the rays whose hit was accepted. hit: functor that
 *  computes u, v, t and Ng, with the signature that Embree's epilogues of packets require. */
template<int K, typename Hit>
__forceinline vbool<K> report(RayHitK<K>& rays, const vbool<K>& lanes, IntersectContext* context,
                              uint32_t surfaceNumber, uint32_t primID, const Hit& hit) {
  return IntersectKEpilogMU<1, K, true>(rays, context, geomIDOf(context, surfaceNumber), primID)(lanes, hit);
}
template<int K, typename Hit>
__forceinline vbool<K> report(RayK<K>& rays, const vbool<K>& lanes, IntersectContext* context, uint32_t surfaceNumber,
                              uint32_t primID, const Hit& hit) {
  vbool<K> remaining = lanes; // Embree removes rays that hit
  return OccludedKEpilogMU<1, K, true>(remaining, rays, context, geomIDOf(context, surfaceNumber), primID)(lanes, hit);
}

/*! True for the ray types of any-hit queries. */
template<typename Rays> struct IsAnyHit;
template<int K> struct IsAnyHit<RayK<K>> {
  static const bool value = true;
};
template<int K> struct IsAnyHit<RayHitK<K>> {
  static const bool value = false;
};

/*! False if nothing reads u, v, t and Ng of a hit: any-hit queries pass them to filter functions only. */
template<typename Rays>
__forceinline bool needsHitData(const Rays&, const IntersectContext*, uint32_t) {
  return true;
}
template<int K>
__forceinline bool needsHitData(const RayK<K>&, const IntersectContext* context, uint32_t surfaceNumber) {
  return unlikely(context->hasContextFilter() ||
                  context->scene->get(geomIDOf(context, surfaceNumber))->hasOcclusionFilter());
}
} // namespace embree::isa::cbvh
