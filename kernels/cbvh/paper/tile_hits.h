// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The grandchildren of a tile (node_cache.h) that a ray intersects or passes, front to back. A ray passes a node if it
 * goes over or under its box (BoxMasks::passed).
 *
 * A rank is a position in this order: 4 c + i is child i of child c, both counted along the ray. The index of its node
 * is the rank with the bits of descending axes flipped. Ranks 1 and 2 of four siblings are alternatives: a ray
 * intersects both only if their boxes overlap along x or y. If the second is nearer, they are swapped. */

#include "block_tiles.h"
#include "node_ray.h"

namespace embree::isa::cbvh {
class TileHits {
public:
  __forceinline TileHits() {}

  /*! Returns a mask of 16 ranks. passedMask: all bits set to include nodes that the ray passes, otherwise 0. */
  __forceinline uint32_t ranksToVisit(uint32_t passedMask) const {
    return (ranks | (ranks >> 16 & passedMask)) & 0xFFFFu;
  }

  /*! Removes a rank and all ranks before it. Returns false if the ray passes the rank's node. */
  __forceinline bool removeUpTo(uint32_t rank) {
    const bool isHit = (ranks >> rank) & 1u;
    ranks &= ~((2u << rank) - 1u) & ~(((2u << rank) - 1u) << 16);
    return isHit;
  }

  /*! True if the ray passes the parent of a grandchild. False if it passes the grandchild only. */
  __forceinline bool passesParent(uint32_t grandchild) const { return !((childHit >> (grandchild >> 2)) & 1u); }

  /*! Index of a rank's grandchild. Bits 2 and 3 are the index of its parent. */
  __forceinline uint32_t grandchild(uint32_t rank) const {
    uint32_t p = rank;
    if (unlikely(swaps != 0u)) {
      if ((swaps >> (p >> 2)) & 1u && isAlternative(p & 3u)) p ^= 3u;
      if (swaps & childSwap && isAlternative(p >> 2)) p ^= 12u;
    }
    return p ^ flip;
  }

  /*! Sets the ranks, and returns 0, if all intersected children have decoded children. Otherwise returns a mask
   *  of the others: the caller must decode their children and call again. sBest: end of the ray, as s. */
  __forceinline uint32_t intersect(const NodeRay& ray, const NodeEntries::Tile& tile, float sBest) {
    BoxRanges<4> childRanges;
    const BoxMasks children = intersectBoxes<vfloat4>(ray, tile.children, sBest, childRanges);
    const uint32_t missing = children.hit & ~tile.decoded;
    if (unlikely(missing != 0u)) return missing;
    childHit = children.hit;
    BoxMasks all = {0u, 0u};
    if (likely(children.hit != 0u)) {
      all = intersectBoxes<vfloatV>(ray, tile.grandchildren, sBest, ranges);
      all.hit &= nodeTables.allOfFour[children.hit];
      all.passed &= nodeTables.allOfFour[children.hit];
    }
    const uint32_t first = ray.flipXY(), second = 1u ^ first, third = 2u ^ first; // children in the order of ranks
    all.passed |= uint32_t(nodeTables.firstOfFour[children.passed]) << first;
    setRanks(all, first);

    const uint32_t either = children.hit | children.passed;
    if (unlikely(((either >> second) & (either >> third) & 1u) != 0u) &&
        childRanges.sNear[third] < childRanges.sNear[second]) {
      swaps |= childSwap;
      // exchanges ranks 4 to 7 and 8 to 11, in both halves
      ranks = (ranks & 0xF00FF00Fu) | (ranks & 0x00F000F0u) << 4 | (ranks & 0x0F000F00u) >> 4;
    }
    swapOverlapping();
    return 0u;
  }

  /*! As intersect(), for a tile above the root. The ray must intersect the root's box, and the grandchildren must
   *  be decoded. */
  __forceinline void intersectAboveRoot(const NodeRay& ray, const NodeEntries::Tile& tile, float sBest) {
    childHit = 1u;
    BoxMasks four = intersectBoxes<vfloat4>(ray, tile.grandchildren, sBest, ranges, 4);
    four.hit &= tile.present;
    four.passed &= tile.present;
    setRanks(four, ray.flipXY());
    swapOverlapping();
  }

  BoxRanges<16> ranges; //!< by grandchild; undefined below children that the ray misses

private:
  static const uint32_t childSwap = 16u;

  static __forceinline bool isAlternative(uint32_t rank) { return rank - 1u < 2u; }

  /*! Converts grandchildren to ranks. m: two masks of 16 bits. first: NodeRay::flipXY. */
  static __forceinline uint32_t toRanks(uint32_t m, uint32_t first) {
    if (first & 1u) {
      m = (m & 0x55555555u) << 1 | ((m >> 1) & 0x55555555u);
      m = (m & 0x0F0F0F0Fu) << 4 | ((m >> 4) & 0x0F0F0F0Fu);
    }
    if (first & 2u) {
      m = (m & 0x33333333u) << 2 | ((m >> 2) & 0x33333333u);
      m = (m & 0x00FF00FFu) << 8 | ((m >> 8) & 0x00FF00FFu);
    }
    return m;
  }

  /*! Sets the ranks of grandchildren, without swaps. first: as above. */
  __forceinline void setRanks(const BoxMasks& masks, uint32_t first) {
    flip = first | first << 2;
    swaps = 0u;
    ranks = toRanks(masks.hit | masks.passed << 16, first);
  }

  /*! Swaps alternatives that are each intersected or passed, if the second is nearer. */
  __forceinline void swapOverlapping() {
    const uint32_t either = ranks | ranks >> 16;
    for (uint32_t rest = either & (either >> 1) & 0x2222u; unlikely(rest != 0u); rest &= rest - 1) {
      const uint32_t rank = uint32_t(bsf(rest));
      if (!(ranges.sNear[grandchild(rank + 1)] < ranges.sNear[grandchild(rank)])) continue;
      swaps |= 1u << (rank >> 2);
      const uint32_t bits = 0x10001u << rank, differs = (ranks ^ ranks >> 1) & bits;
      ranks ^= differs | differs << 1;
    }
  }

  /*! Lower half: intersected ranks. Upper half: passed ranks. A passed child has one, its first. */
  uint32_t ranks;
  uint32_t childHit; //!< mask of children that the ray intersects
  uint32_t flip;     //!< bits in which ranks and grandchildren differ, without swaps
  uint32_t swaps;    //!< a bit per four ranks with swapped alternatives, and childSwap for the children
};
} // namespace embree::isa::cbvh
