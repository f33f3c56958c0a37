// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A cube with texture coordinates, as a cage of libembree_cbvh, and a ray that hits it. */

#include <cbvh/cbvh.h>

#include <cmath>

namespace programs::test {

inline const float cubeVertices[] = {-1, -1, -1, 1,  -1, -1, -1, 1, -1, 1, 1, -1, -1,
                                     -1, 1,  1,  -1, 1,  -1, 1,  1, 1,  1, 1, 0};
inline const unsigned cubeFaces[] = {4, 4, 4, 4, 4, 4},
                      cubeIndices[] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
inline const float* const cubeSteps[] = {cubeVertices};
inline const float corners[] = {0, 0, 1, 0, 1, 1, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1};
inline const CbvhAttribute attribute = {corners, 8, 8, 2, nullptr, CBVH_BOUNDARY_SMOOTH};

inline CbvhCage cube() {
  CbvhCage cage = CbvhCage();
  cage.numFaces = 6;
  cage.faceVertexCounts = cubeFaces;
  cage.numIndices = 24;
  cage.indices = cubeIndices;
  cage.vertices = {8, 12, cubeSteps, 1, 0, 1};
  cage.rate = 8;
  cage.numAttributes = 1;
  cage.attributes = &attribute;
  return cage;
}

inline CbvhRayHit rayFromAbove() {
  CbvhRayHit r = CbvhRayHit();
  r.ray.org_x = r.ray.org_y = 0.01f;
  r.ray.org_z = 5;
  r.ray.dir_z = -1;
  r.ray.tfar = INFINITY;
  r.ray.mask = 1;
  return r;
}

} // namespace programs::test
