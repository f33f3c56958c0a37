// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Estimates of the bytes that Embree's own kernels use for diced geometry, without vertices and indices.
 * docs/performance.md has the measurements. */

#include <cstddef>

namespace embree
{
  /*! of grids, which it stores by 2 x 2 quads */
  inline size_t bytesOfGridInEmbree (size_t quadsX, size_t quadsY) { return 68*((quadsX+1)/2)*((quadsY+1)/2); }

  /*! of a quad of a quad mesh, and of a triangle; of triangles less than was seen */
  static const size_t bytesOfQuadInEmbree = 85, bytesOfTriangleInEmbree = 60;
}
