// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Estimated bytes of Embree's own acceleration structures and of blocks, without the application's buffers. They decide
 * whether compression saves memory, and are printed at verbosity 1. Measurements are in docs/measurements.md. Those for
 * grids are in base/grid_bytes.h. */

#include "../base/grid_bytes.h"
#include "../embree/scene.h"
#include <cstddef>

namespace embree {
/*! True if Embree's nodes for static grids have eight children. */
inline bool hasWideNodes(Device* device) {
#if defined(EMBREE_TARGET_SIMD8)
  return device->canUseAVX();
#else
  return false;
#endif
}

/*! A region of a mesh as cVERT at the default precision of meshes: 5.5 bytes per quad in full blocks, and `tables`,
 *  the bytes of the tables of numbers. */
inline size_t bytesOfMeshGrid(size_t quadsX, size_t quadsY, size_t tables) {
  return bytesOfGridBlocks(quadsX, quadsY, true) + 4 * quadsX * quadsY + tables;
}

/*! Mesh blocks at the default precision, with their share of the tree. */
inline size_t bytesOfMeshTriangles(size_t triangles) { return 7 * triangles; }

/*! A quad of a quad mesh. */
inline size_t bytesOfQuadInEmbree(unsigned numTimeSteps) {
  return numTimeSteps == 1 ? 85 : numTimeSteps == 2 ? 56 : 64;
}

/*! A triangle of a triangle mesh. For one time step, a lower bound of the measurements. */
inline size_t bytesOfTriangleInEmbree(unsigned numTimeSteps) {
  return numTimeSteps == 1 ? 60 : numTimeSteps == 2 ? 52 : 80;
}
inline size_t bytesOfPairInEmbree(unsigned numTimeSteps) { return 2 * bytesOfTriangleInEmbree(numTimeSteps); }

/*! GRID's grids of a cage. bytesOfStep: for one time step. */
inline size_t bytesOfMovingGrids(size_t bytesOfStep, unsigned numTimeSteps) {
  return numTimeSteps == 1 ? bytesOfStep : size_t(double(bytesOfStep) * (0.85 * numTimeSteps - 0.4));
}
} // namespace embree
