// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Morton order of nodes and leaves: bits of x and y alternate, x in the even bits. The children of node m are nodes 4 m
 * to 4 m + 3 of the next level. */

#ifndef CBVH_PAPER_MORTON_H
#define CBVH_PAPER_MORTON_H

#include "../base/codec_names.h"

CBVH_BEGIN

/*! Moves 8 bits to the even bits. x: below 256. */
CVERT_FUNCTION uint32_t spreadBits(uint32_t x) {
  x = (x | (x << 4)) & 0x0F0Fu;
  x = (x | (x << 2)) & 0x3333u;
  return (x | (x << 1)) & 0x5555u;
}

/*! Inverse of spreadBits. */
CVERT_FUNCTION uint32_t gatherBits(uint32_t x) {
  x &= 0x5555u;
  x = (x | (x >> 1)) & 0x3333u;
  x = (x | (x >> 2)) & 0x0F0Fu;
  return (x | (x >> 4)) & 0x00FFu;
}

CVERT_FUNCTION uint32_t morton(uint32_t x, uint32_t y) { return spreadBits(x) | (spreadBits(y) << 1); }
CVERT_FUNCTION uint32_t mortonX(uint32_t m) { return gatherBits(m); }
CVERT_FUNCTION uint32_t mortonY(uint32_t m) { return gatherBits(m >> 1); }

/*! Coordinate on an axis, 0 or 1, of a child or of a box's corner. */
CVERT_FUNCTION int childCoordinate(int child, int axis) { return (child >> axis) & 1; }

/*! Number of nodes in the first n levels, which is also the index of the first node of level n. */
CVERT_FUNCTION uint32_t nodesOfLevels(uint32_t n) { return ((1u << (2 * n)) - 1u) / 3u; }

CBVH_END

#endif
