// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersectors of moving blocks. */

#include "intersector1.h"
#include "moving_block.h"

namespace embree::isa::cbvh {
template<typename RayType>
__noinline bool intersectMovingVert(RayType& ray, IntersectContext* context, VertRay& vertRay,
                                    const VertHeader* block) {
  const VertMotion motion = motionOf(block);
  if (unlikely(!isPresent(motion, ray.time()))) return false;
  return VertIntersector1<RayType, MovingVertBlock>::intersect(ray, context, vertRay, block,
                                                               timeInMotion(motion, ray.time()));
}

/*! block: a MeshHeader. */
template<typename RayType>
__noinline bool intersectMovingMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block) {
  const VertMotion motion = motionOfMesh((const MeshHeader*)block);
  if (unlikely(!isPresent(motion, ray.time()))) return false;
  return VertIntersector1<RayType, MovingMeshBlock>::intersect(ray, context, vertRay, (const VertHeader*)block,
                                                               timeInMotion(motion, ray.time()));
}
} // namespace embree::isa::cbvh
