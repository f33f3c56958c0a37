// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What Embree's own kernels take for geometry that was diced, about, besides vertices and indices. PERFORMANCE.md has what was seen. */

#include <cstddef>

namespace embree
{
  /*! of grids, which it stores by 2 x 2 quads */
  inline size_t bytesOfGridInEmbree (size_t quadsX, size_t quadsY) { return 68*((quadsX+1)/2)*((quadsY+1)/2); }

  /*! of a quad of a quad mesh, and of a triangle; of triangles less than was seen */
  static const size_t bytesOfQuadInEmbree = 85, bytesOfTriangleInEmbree = 60;
}
