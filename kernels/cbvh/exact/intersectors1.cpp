// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for one instruction set. */

#include "intersectors1.h"
#include "intersector1.h"

namespace embree::isa::cbvh {
template bool intersectVert(RayHit&, IntersectContext*, VertRay&, const VertHeader*);
template bool intersectVert(Ray&, IntersectContext*, VertRay&, const VertHeader*);
template bool intersectMesh(RayHit&, IntersectContext*, VertRay&, const void*);
template bool intersectMesh(Ray&, IntersectContext*, VertRay&, const void*);
} // namespace embree::isa::cbvh
