// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Estimates of the bytes that Embree's own kernels, and blocks, use for a surface, without vertices and indices.
 * docs/performance.md has the measurements. */

#include <cstddef>

namespace embree
{
  /*! of grids, which it stores by 2 x 2 quads, whether they move or not */
  inline size_t bytesOfGridInEmbree (size_t quadsX, size_t quadsY) { return 68*((quadsX+1)/2)*((quadsY+1)/2); }

  /*! Estimate of the bytes of cVERT for a grid, with its part of the tree: as was measured, 130 per block, 8 more with
   *  numbers that follow a pattern, and 1 per quad. */
  inline size_t bytesOfGridBlocks (size_t quadsX, size_t quadsY, bool haveNumbers) {
    return (haveNumbers ? 138 : 130)*((quadsX+15)/16)*((quadsY+15)/16) + quadsX*quadsY;
  }

  /*! The same for triangles of mesh blocks. */
  inline size_t bytesOfMeshTriangles (size_t triangles) { return 13*triangles/2; }

  /*! of a quad of a quad mesh */
  inline size_t bytesOfQuadInEmbree (unsigned numTimeSteps) { return numTimeSteps == 1 ? 85 : numTimeSteps == 2 ? 56 : 64; }

  /*! of a triangle; at one time step less than was seen */
  inline size_t bytesOfTriangleInEmbree (unsigned numTimeSteps) { return numTimeSteps == 1 ? 60 : numTimeSteps == 2 ? 52 : 80; }
  inline size_t bytesOfPairInEmbree (unsigned numTimeSteps) { return 2*bytesOfTriangleInEmbree(numTimeSteps); }

  /*! of a subdivision surface's grids with several time steps. still: the same at one step */
  inline size_t bytesOfMovingGrids (size_t still, unsigned numTimeSteps) { return numTimeSteps == 1 ? still : size_t(double(still)*(0.85*numTimeSteps-0.4)); }
}
