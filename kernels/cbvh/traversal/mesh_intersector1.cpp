// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiles the single-ray intersectors of mesh blocks and mesh tiles, which intersector1.cpp and
 * moving_intersector1.cpp call. */

#include "../exact/mesh_intersector1.h"
#include "../exact/moving_mesh_intersector1.h"

namespace embree::isa::cbvh {
template bool intersectMesh(Ray&, IntersectContext*, VertRay&, const void*);
template bool intersectMesh(RayHit&, IntersectContext*, VertRay&, const void*);
template bool intersectMeshTile(Ray&, IntersectContext*, VertRay&, const void*);
template bool intersectMeshTile(RayHit&, IntersectContext*, VertRay&, const void*);
template bool intersectMovingMesh(Ray&, IntersectContext*, VertRay&, const void*);
template bool intersectMovingMesh(RayHit&, IntersectContext*, VertRay&, const void*);
template bool intersectMovingMeshTile(Ray&, IntersectContext*, VertRay&, const void*);
template bool intersectMovingMeshTile(RayHit&, IntersectContext*, VertRay&, const void*);
} // namespace embree::isa::cbvh
