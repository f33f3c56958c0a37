// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Estimated bytes of Embree's own acceleration structures and of blocks, without the application's buffers. They decide
 * whether compression saves memory, and are printed at verbosity 1. Measurements are in docs/performance.md. */

#include "../embree/scene.h"
#include <cstddef>

namespace embree {
/*! A grid of a grid geometry, which Embree divides into leaves of 2 x 2 quads. Its nodes for static grids have eight
 *  children with AVX, otherwise four: 11 to 12 bytes per quad with isa=sse2. */
inline size_t bytesOfGridInEmbree(size_t quadsX, size_t quadsY, unsigned numTimeSteps, Device* device) {
#if defined(EMBREE_TARGET_SIMD8)
  const bool isWide = device->canUseAVX();
#else
  const bool isWide = false;
#endif
  return (numTimeSteps == 1 && !isWide ? 46 : 68) * ((quadsX + 1) / 2) * ((quadsY + 1) / 2);
}

/*! A grid as cVERT, with its share of the tree: a lower bound of the measurements. A block needs 8 more bytes if its
 *  quads have numbers (primIDs) that follow a pattern. */
inline size_t bytesOfGridBlocks(size_t quadsX, size_t quadsY, bool haveNumbers) {
  return (haveNumbers ? 138 : 130) * ((quadsX + 15) / 16) * ((quadsY + 15) / 16) + quadsX * quadsY;
}

/*! Lower bound of the bytes that motion adds to a grid as cVERT. Each block has a motion section, and each later step
 *  has a header, an entry in the table, and words and margins of groups (docs/formats/motion.md). */
inline size_t bytesOfLaterSteps(size_t quadsX, size_t quadsY, unsigned numTimeSteps) {
  if (numTimeSteps == 1) return 0;
  const size_t blocks = ((quadsX + 15) / 16) * ((quadsY + 15) / 16), groups = ((quadsX + 3) / 4) * ((quadsY + 3) / 4);
  return 16 * blocks + (numTimeSteps - 1) * (68 * blocks + 4 * groups);
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
