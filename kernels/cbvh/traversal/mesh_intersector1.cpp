// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiles the single-ray intersectors of mesh blocks and mesh tiles, which intersector1.cpp calls. */

#include "../exact/mesh_intersector1.h"

namespace embree::isa::cbvh {
template bool intersectMesh(Ray&, IntersectContext*, VertRay&, const void*);
template bool intersectMesh(RayHit&, IntersectContext*, VertRay&, const void*);
template bool intersectMeshTile(Ray&, IntersectContext*, VertRay&, const void*);
template bool intersectMeshTile(RayHit&, IntersectContext*, VertRay&, const void*);
} // namespace embree::isa::cbvh
