// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Intersector of mesh blocks and mesh tiles at rest for packets: one ray after the other, with boxes, then triangles,
 * in lanes. */

#include "hitsK.h"
#include "mesh_intersector1.h"

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

  /*! The same for a mesh tile. */
  static __noinline vbool<K> intersectTile(const vbool<K>& valid, Rays& rays, IntersectContext* context,
                                           VertRays<K>& vertRays, const void* tile) {
    vertRays.set(rays);
    uint32_t found = 0;
    for (uint32_t rest = uint32_t(movemask(valid)); rest; rest &= rest - 1) {
      const uint32_t k = uint32_t(bsf(rest));
      const VertRay ray = rayOf(vertRays, k);
      if (intersectGroupsOfTile<IsAnyHit<Rays>::value>(VertTargetK<K, Rays>{rays, context, k}, ray, vertRays.nearest(k),
                                                       (const MeshTileHeader*)tile))
        found |= 1u << k;
    }
    return vbool<K>(int(found));
  }

private:
  /*! Ray k with the members that tests of boxes read. */
  static __forceinline VertRay rayOf(VertRays<K>& vertRays, uint32_t k) {
    VertRay ray = vertRays.ray(k);
    for (int i = 0; i < 4; i++) ray.rcp[i] = vertRays.rcp[i % 3][k];
    ray.org[3] = ray.org[0];
    ray.dir[3] = ray.dir[0];
    ray.largestComponent = vertRays.largestComponent[k];
    ray.negativeAxes = uint32_t(vertRays.rayClass[k]) >> 2;
    return ray;
  }

  static __forceinline bool intersectOne(uint32_t k, Rays& rays, IntersectContext* context, VertRays<K>& vertRays,
                                         const VertHeader* block, const CachedMeshBlock& cached) {
    const VertRay ray = rayOf(vertRays, k);
    alignas(64) float enter[16];
    const uint32_t groups = intersectGroupBoxes(ray, rays.tnear()[k], rays.tfar[k], cached.boxes(), enter);
    return intersectGroups<IsAnyHit<Rays>::value>(VertTargetK<K, Rays>{rays, context, k}, ray, vertRays.nearest(k),
                                                  block, cached, groups, enter);
  }
};
} // namespace embree::isa::cbvh
