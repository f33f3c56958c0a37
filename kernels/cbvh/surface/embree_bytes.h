// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Estimated bytes of Embree's kernels and of blocks, without vertices and indices. docs/performance.md has the
 * measurements. */

#include <cstddef>

namespace embree
{
  /*! As 2 x 2 quads. Motion does not change the size. */
  inline size_t bytesOfGridInEmbree (size_t quadsX, size_t quadsY) { return 68*((quadsX+1)/2)*((quadsY+1)/2); }

  /*! As cVERT, with the tree's share: 130 bytes per block, 8 more if numbers follow a pattern, and 1 per quad. */
  inline size_t bytesOfGridBlocks (size_t quadsX, size_t quadsY, bool haveNumbers) {
    return (haveNumbers ? 138 : 130)*((quadsX+15)/16)*((quadsY+15)/16) + quadsX*quadsY;
  }

  /*! For a mesh at the default precision, which needs about 5 bytes per quad. tables: bytes of the tables of
   *  numbers. */
  inline size_t bytesOfMeshGrid (size_t quadsX, size_t quadsY, size_t tables) {
    return bytesOfGridBlocks(quadsX,quadsY,true) + 4*quadsX*quadsY + tables;
  }

  /*! At the default precision, with the tree's share. */
  inline size_t bytesOfMeshTriangles (size_t triangles) { return 7*triangles; }

  inline size_t bytesOfQuadInEmbree (unsigned numTimeSteps) {
    return numTimeSteps == 1 ? 85 : numTimeSteps == 2 ? 56 : 64;
  }

  /*! For one time step, a lower bound of the measurements. */
  inline size_t bytesOfTriangleInEmbree (unsigned numTimeSteps) {
    return numTimeSteps == 1 ? 60 : numTimeSteps == 2 ? 52 : 80;
  }
  inline size_t bytesOfPairInEmbree (unsigned numTimeSteps) { return 2*bytesOfTriangleInEmbree(numTimeSteps); }

  /*! still: bytes at one time step. */
  inline size_t bytesOfMovingGrids (size_t still, unsigned numTimeSteps) {
    return numTimeSteps == 1 ? still : size_t(double(still)*(0.85*numTimeSteps-0.4));
  }
}
