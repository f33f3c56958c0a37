// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Intersector of mesh blocks at rest for packets: one ray after the other, with boxes, then triangles, in lanes. */

#include "hitsK.h"
#include "intersector1.h"

namespace embree::isa::cbvh {
template<int K, typename Rays>
class MeshIntersectorK {
public:
  /*! Returns the rays that accepted a hit. Any-hit rays end at their first accepted hit. block: a MeshHeader,
   *  without motion. */
  static __noinline vbool<K> intersect(const vbool<K>& valid, Rays& rays, IntersectContext* context,
                                       VertRays<K>& vertRays, const void* block) {
    vertRays.set(rays);
    const CachedMeshBlock cached(vertRays, (const VertHeader*)block);
    if (cached.decodedBoxes() == nullptr && !cached.isValid()) return vbool<K>(false);
    uint32_t found = 0;
    for (uint32_t rest = uint32_t(movemask(valid)); rest; rest &= rest - 1) {
      const uint32_t k = uint32_t(bsf(rest));
      if (intersectOne(k, rays, context, vertRays, (const VertHeader*)block, cached)) found |= 1u << k;
    }
    return vbool<K>(int(found));
  }

private:
  static __forceinline bool intersectOne(uint32_t k, Rays& rays, IntersectContext* context, VertRays<K>& vertRays,
                                         const VertHeader* block, const CachedMeshBlock& cached) {
    // ray() leaves out the members that tests of boxes read
    VertRay ray = vertRays.ray(k);
    for (int i = 0; i < 3; i++) ray.rcp[i] = vertRays.rcp[i][k];
    ray.largestComponent = vertRays.largestComponent[k];
    ray.negativeAxes = uint32_t(vertRays.rayClass[k]) >> 2;
    alignas(64) float enter[16];
    const uint32_t groups = intersectGroupBoxes(ray, rays.tnear()[k], rays.tfar[k], cached.boxes(), enter);
    return intersectGroups<IsAnyHit<Rays>::value>(VertTargetK<K, Rays>{rays, context, k}, ray, vertRays.nearest(k),
                                                  block, cached, groups, enter);
  }
};
} // namespace embree::isa::cbvh
