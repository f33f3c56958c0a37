// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersectors of mesh blocks and mesh tiles at rest. */

#include "cached_mesh.h"
#include "mesh_tile_intersector1.h"

namespace embree::isa::cbvh {
template<typename RayType>
__noinline bool intersectMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block) {
  return VertIntersector1<RayType, CachedMeshBlock>::intersect(ray, context, vertRay, (const VertHeader*)block);
}

template<typename RayType>
__noinline bool intersectMeshTile(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* tile) {
  vertRay.set(ray);
  return intersectGroupsOfTile<IsAnyHit<RayType>::value>(VertTarget1<RayType>{ray, context}, vertRay, vertRay.nearest,
                                                         (const MeshTileHeader*)tile);
}
} // namespace embree::isa::cbvh
