// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Divides a patch of a cage into blocks with frames. */

#include "block.h"
#include "../surface/plan.h"

namespace embree::isa {
/*! A patch as blocks of 2^height x 2^height quads. Along u and v, the higher rate of two opposite edges determines
 *  the number of blocks:
 *
 *       rate 9
 *     +---+---+---+
 *     |   |   |   |    height 2: 3 x 2 blocks, 12 x 8 quads
 *   8 +---+---+---+ 5
 *     |   |   |   |    Edges of a lower rate keep their own vertices (spread_borders.h).
 *     +---+---+---+
 *       rate 3 */
struct PatchTiling {
  unsigned height = 0;
  unsigned x = 0, y = 0;  //!< number of blocks along u and v
  Vec2i quads = Vec2i(0); //!< quads of all blocks together

  size_t size() const { return size_t(x) * size_t(y); }
  unsigned quadsX() const { return unsigned(quads.x); }
  unsigned quadsY() const { return unsigned(quads.y); }
};

/*! Smallest level, up to maxFramedLevel, with 2^level not below the highest rate. */
inline unsigned levelOf(const float rate[4]) {
  unsigned level = 0;
  const float highest = max(max(rate[0], rate[1]), max(rate[2], rate[3]));
  while (level < cbvh::maxFramedLevel && float(1u << level) < highest) level++;
  return level;
}

/*! Blocks have 2^max(level-frameLevel,0) quads per side, or fewer if the patch then needs fewer bytes, for example
 *  because it is narrow. */
inline PatchTiling tilingOf(cbvh::Kind kind, const float rate[4], unsigned frameLevel) {
  const unsigned level = levelOf(rate);
  const Vec2i quads = SubdivPatch1Base::computeGridSize(rate) - Vec2i(1);
  PatchTiling best;
  size_t bytesOfBest = 0;
  for (unsigned height = 0; height <= level - min(frameLevel, level); height++) {
    PatchTiling t;
    t.height = height;
    t.x = (unsigned(quads.x - 1) >> height) + 1;
    t.y = (unsigned(quads.y - 1) >> height) + 1;
    t.quads = Vec2i(int(t.x << height), int(t.y << height));
    const size_t bytes = t.size() * cbvh::blockLayout(uint32_t(kind), height).stride;
    if (height == 0 || bytes <= bytesOfBest) {
      best = t;
      bytesOfBest = bytes;
    }
  }
  return best;
}
} // namespace embree::isa
