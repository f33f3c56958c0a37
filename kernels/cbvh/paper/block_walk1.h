// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Traverses a block's quadtree with a single ray, front to back, two levels (a tile, node_cache.h) at a time. A mask
 * stores the nodes of a tile that are not visited yet, so the stack has one entry per level of tiles.
 *
 * The Visitor intersects the leaves, front to back. It has these members, and a type LeafTile (node_cache.h):
 *
 *    LeafTile& leafTile (uint32_t m)
 *      Returns the tile of the last level whose grandchildren are leaves 16 m to 16 m + 15.
 *    bool leaf (const LeafTile& tile, uint32_t m, uint32_t grandchild, const BoxRanges<16>& ranges)
 *      Intersects leaf 16 m + grandchild, whose box the ray intersects. Returns true to end the walk.
 *    bool passSubtree (bool above)
 *      Called if the ray passes over (`above`) or under an entire subtree. Returns true to end the walk.
 *    uint32_t passedMask
 *      All bits set to request calls of passSubtree, otherwise 0. May change.
 *    float sBest
 *      Nodes that the ray enters at a greater s are skipped. The visitor may decrease it. */

#include "tile_hits.h"

namespace embree::isa::cbvh {
template<typename Visitor>
class BlockWalk1 {
  typedef typename Visitor::LeafTile LeafTile;

  const NodeRay& ray;
  BlockTiles& tiles;
  Visitor& visitor;
  const int first, last;

  struct Level {
    TileHits hits;   //!< nodes that were not visited yet
    uint32_t m;      //!< index of the tile's node in its level
    uint32_t number; //!< of the tile, see BlockTiles::isCached
    NodeEntries::Tile* tile;
  };
  Level levels[maxFramedLevel / 2 + 1];

public:
  __forceinline BlockWalk1(const NodeRay& ray, BlockTiles& tiles, Visitor& visitor)
    : ray(ray),
      tiles(tiles),
      visitor(visitor),
      first(tiles.firstLevel()),
      last(tiles.lastLevel()) {}

  /*! Returns true if the visitor ended the walk. */
  __forceinline bool run() {
    Level* l = levels;
    int level = first;
    enterLevel(*l, level, 0);
    while (true) {
      const uint32_t toVisit = l->hits.ranksToVisit(visitor.passedMask);
      if (toVisit == 0) {
        if (level == first) return false;
        level -= 2;
        l--;
        continue;
      }
      const uint32_t rank = uint32_t(bsf(toVisit)), grandchild = l->hits.grandchild(rank);
      if (unlikely(!l->hits.removeUpTo(rank))) {
        if (visitor.passSubtree(isAbove(*l, level, grandchild))) return true;
        continue;
      }
      if (unlikely(l->hits.ranges.sNear[grandchild] > visitor.sBest)) continue;
      if (level == last) {
        const LeafTile& tile = (const LeafTile&)tileOf(*l, level, grandchild);
        if (visitor.leaf(tile, l->m, grandchild, l->hits.ranges)) return true;
        continue;
      }
      level += 2;
      enterLevel(l[1], level, 16 * l->m + grandchild);
      l++;
    }
  }

private:
  /*! Intersects the tile below node m. */
  __forceinline void enterLevel(Level& l, int level, uint32_t m) {
    l.m = m;
    if (level == last) intersectTile(visitor.leafTile(m), l);
    else intersectTile(tiles.tile(level, m), l);
  }

  template<typename Tile>
  __forceinline void intersectTile(Tile& tile, Level& l) {
    if (unlikely(tile.isAboveRoot())) {
      tiles.ensureDecoded(tile, 1u);
      l.hits.intersectAboveRoot(ray, tile, visitor.sBest);
    } else
      while (const uint32_t missing = l.hits.intersect(ray, tile, visitor.sBest)) tiles.ensureDecoded(tile, missing);
    l.tile = &tile;
    l.number = tile.number;
  }

  /*! Returns the tile with a decoded grandchild. Other tiles or a filter function's rays may have evicted it. */
  __forceinline NodeEntries::Tile& tileOf(Level& l, int level, uint32_t grandchild) {
    if (unlikely(!tiles.isDecoded(*l.tile, l.number, grandchild))) decodeAgain(l, level, 1u << (grandchild >> 2));
    return *l.tile;
  }

  /*! As above, with decoded children only. */
  __forceinline NodeEntries::Tile& tileOf(Level& l, int level) {
    if (unlikely(!tiles.isCached(*l.tile, l.number))) decodeAgain(l, level, 0u);
    return *l.tile;
  }

  __noinline void decodeAgain(Level& l, int level, uint32_t mask) {
    if (level == last) {
      LeafTile& tile = visitor.leafTile(l.m);
      tiles.ensureDecoded(tile, mask);
      l.tile = &tile;
    } else {
      NodeEntries::Tile& tile = tiles.tile(level, l.m);
      tiles.ensureDecoded(tile, mask);
      l.tile = &tile;
    }
  }

  /*! True if the ray passes over, not under, the node that it misses: the grandchild's parent, or else the
   *  grandchild. */
  __forceinline bool isAbove(Level& l, int level, uint32_t grandchild) {
    return l.hits.passesParent(grandchild) ? ray.isAbove(tileOf(l, level).children, grandchild >> 2)
                                           : ray.isAbove(tileOf(l, level, grandchild).grandchildren, grandchild);
  }
};
} // namespace embree::isa::cbvh
