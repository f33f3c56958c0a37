// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersectors of blocks without frames, for RayHit (closest hit) and Ray (any hit). intersectors1.cpp
 * and moving_intersectors1.cpp compile them. */

#include "../embree/traversal.h"
#include "ray.h"

namespace embree::isa::cbvh {
/* These functions return true if a hit was accepted. vertRay: one per ray, the same for all its blocks; the first call
 * sets it. Mesh blocks: a MeshHeader. Damaged blocks have no hits. */

template<typename RayType>
bool intersectVert(RayType& ray, IntersectContext* context, VertRay& vertRay, const VertHeader* block);

template<typename RayType>
bool intersectMovingVert(RayType& ray, IntersectContext* context, VertRay& vertRay, const VertHeader* block);

template<typename RayType>
bool intersectMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block);

template<typename RayType>
bool intersectMovingMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block);
} // namespace embree::isa::cbvh
