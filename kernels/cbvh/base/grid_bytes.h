// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Estimated bytes of a grid as cVERT and in Embree's grid kernel, without the application's buffers. They decide
 * whether a grid geometry is compressed. Measurements are in docs/measurements.md. Independent of Embree, because the
 * interposer compiles it, too. */

#include <cstddef>

namespace embree {
/*! A grid of a grid geometry, which Embree divides into leaves of 2 x 2 quads. Its nodes for static grids have eight
 *  children with AVX (hasWideNodes), otherwise four: 11 to 12 bytes per quad with isa=sse2. */
inline size_t bytesOfGridInEmbree(size_t quadsX, size_t quadsY, unsigned numTimeSteps, bool hasWideNodes) {
  return (numTimeSteps == 1 && !hasWideNodes ? 46 : 68) * ((quadsX + 1) / 2) * ((quadsY + 1) / 2);
}

/*! A grid as cVERT, with its share of the tree: a lower bound of the measurements. A block needs 8 more bytes if its
 *  quads have numbers (primIDs) that follow a pattern. */
inline size_t bytesOfGridBlocks(size_t quadsX, size_t quadsY, bool haveNumbers) {
  return (haveNumbers ? 138 : 130) * ((quadsX + 15) / 16) * ((quadsY + 15) / 16) + quadsX * quadsY;
}

/*! Lower bound of the bytes that motion adds to a grid as cVERT. Each block has a motion section, and each later step
 *  has a header, an entry in the table, and words and margins of groups (docs/formats/block.md). */
inline size_t bytesOfLaterSteps(size_t quadsX, size_t quadsY, unsigned numTimeSteps) {
  if (numTimeSteps == 1) return 0;
  const size_t blocks = ((quadsX + 15) / 16) * ((quadsY + 15) / 16), groups = ((quadsX + 3) / 4) * ((quadsY + 3) / 4);
  return 16 * blocks + (numTimeSteps - 1) * (68 * blocks + 4 * groups);
}

/*! Sums over grids of a geometry. */
struct GridBytes {
  size_t blocks = 0, embree = 0;

  GridBytes operator+(const GridBytes& other) const { return {blocks + other.blocks, embree + other.embree}; }
  bool areBlocksSmaller() const { return blocks <= embree; }
};

/*! verticesX, verticesY: of the grid. Returns zeros for a grid without quads. */
inline GridBytes bytesOfGrid(size_t verticesX, size_t verticesY, unsigned numTimeSteps, bool hasWideNodes) {
  if (verticesX < 2 || verticesY < 2) return GridBytes();
  const size_t x = verticesX - 1, y = verticesY - 1;
  return {bytesOfGridBlocks(x, y, false) + bytesOfLaterSteps(x, y, numTimeSteps),
          bytesOfGridInEmbree(x, y, numTimeSteps, hasWideNodes)};
}
} // namespace embree
