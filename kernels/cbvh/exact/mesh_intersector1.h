// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersectors of mesh blocks, at rest and moving. */

#include "cached_mesh.h"
#include "intersector1.h"
#include "moving_mesh.h"

namespace embree::isa::cbvh {
/*! As intersectVert. block: a MeshHeader. */
template<typename RayType>
__noinline bool intersectMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block) {
  return VertIntersector1<RayType, CachedMeshBlock>::intersect(ray, context, vertRay, (const VertHeader*)block);
}

/*! As intersectMovingVert. block: a MeshHeader. */
template<typename RayType>
__noinline bool intersectMovingMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block) {
  const VertMotion motion = motionOfMesh((const MeshHeader*)block);
  if (unlikely(!isPresent(motion, ray.time()))) return false;
  return VertIntersector1<RayType, MovingMeshBlock>::intersect(ray, context, vertRay, (const VertHeader*)block,
                                                               timeInMotion(motion, ray.time()));
}
} // namespace embree::isa::cbvh
