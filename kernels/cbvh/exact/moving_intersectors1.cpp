// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for one instruction set. */

#include "intersectors1.h"
#include "moving_intersector1.h"

namespace embree::isa::cbvh {
template bool intersectMovingVert(RayHit&, IntersectContext*, VertRay&, const VertHeader*);
template bool intersectMovingVert(Ray&, IntersectContext*, VertRay&, const VertHeader*);
template bool intersectMovingMesh(RayHit&, IntersectContext*, VertRay&, const void*);
template bool intersectMovingMesh(Ray&, IntersectContext*, VertRay&, const void*);
} // namespace embree::isa::cbvh
