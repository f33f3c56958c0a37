// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Traverses a block's quadtree with a packet. Each ray visits nodes in the order of BlockWalk1, and therefore has the
 * same hits.
 *
 * Rays whose directions have the same signs along x and y in the frame share a walk. If boxes overlap, some rays may
 * require two children in the opposite order. The first child is then visited twice: after the second child for these
 * rays, before it for the others.
 *
 * The Visitor intersects the leaves. It has these members, and a type LeafTile (node_cache.h):
 *
 *    LeafTile& leafTile (uint32_t m)
 *      As in BlockWalk1.
 *    void leaf (const LeafTile& tile, uint32_t m, uint32_t grandchild, const BoxRangesK<K>& box, const vbool<K>& lanes)
 *      Intersects leaf 16 m + grandchild, whose box the rays in `lanes` intersect.
 *    void passBoxes (const vbool<K>& above, const vbool<K>& lanes)
 *      Called if the rays in `lanes` pass over (`above`) or under an entire subtree.
 *    vbool<K> needsPassedBoxes ()
 *      Rays for which passBoxes() must be called. May change.
 *    bool tracksPassedBoxes
 *      Constant. If false, the two functions above are not called.
 *    vbool<K> activeRays
 *      Rays that continue the walk.
 *    vfloat<K> sBest
 *      Nodes that a ray enters at a greater s are skipped for it. */

#include "block_tiles.h"
#include "node_rays.h"

namespace embree::isa::cbvh {
template<int K, typename Visitor>
class BlockWalkK {
  typedef typename Visitor::LeafTile LeafTile;
  typedef NodeEntries::Tile Tile;

  const NodeRays<K>& rays;
  BlockTiles& tiles;
  Visitor& visitor;
  const int first, last;
  uint32_t flip; //!< bits 0 and 1: rays of this walk descend along x and y

public:
  __forceinline BlockWalkK(const NodeRays<K>& rays, BlockTiles& tiles, Visitor& visitor)
    : rays(rays),
      tiles(tiles),
      visitor(visitor),
      first(tiles.firstLevel()),
      last(tiles.lastLevel()) {}

  __forceinline void run(const vbool<K>& lanes) {
    const uint32_t x = uint32_t(movemask(rays.descends[0])), y = uint32_t(movemask(rays.descends[1]));
    for (uint32_t rest = uint32_t(movemask(lanes)); rest;) {
      const uint32_t k = uint32_t(bsf(rest));
      flip = ((x >> k) & 1u) | ((y >> k) & 1u) << 1;
      const uint32_t same = rest & (flip & 1u ? x : ~x) & (flip & 2u ? y : ~y);
      rest &= ~same;
      intersectTile(first, 0, toLanes(same));
    }
  }

private:
  static __forceinline vbool<K> toLanes(uint32_t mask) { return vbool<K>(int(mask)); }

  /*! Visits of four siblings, in order. One node can occur twice. */
  struct Visits {
    BoxRangesK<K> box[4]; //!< by node
    vbool<K> lanes[5];
    uint32_t node[5];
    uint32_t number; //!< number of visits

    template<int N>
    __forceinline Visits(const BlockWalkK& walk, const NodePlanes<N>& planes, uint32_t firstNode, uint32_t present,
                         const vbool<K>& lanes)
      : number(0) {
      vbool<K> visitors[4];
      for (uint32_t i = 0; i < 4; i++) {
        if (likely(present == 15u) || (present >> i) & 1u) {
          box[i].set(walk.rays, walk.flip, planes, firstNode + i);
          visitors[i] = lanes & (Visitor::tracksPassedBoxes ? box[i].overlapsXY(walk.visitor.sBest)
                                                            : box[i].intersects(walk.visitor.sBest));
        } else visitors[i] = vbool<K>(false);
      }
      const uint32_t a = walk.flip ^ 1u, b = walk.flip ^ 2u;
      add(walk.flip, visitors[walk.flip]);
      const vbool<K> swapped = visitors[a] & visitors[b] & (box[b].sNear < box[a].sNear);
      if (likely(none(swapped))) {
        add(a, visitors[a]);
        add(b, visitors[b]);
      } else {
        add(a, visitors[a] & !swapped);
        add(b, visitors[b]);
        add(a, swapped);
      }
      add(walk.flip ^ 3u, visitors[walk.flip ^ 3u]);
    }

    __forceinline void add(uint32_t i, const vbool<K>& rays) {
      lanes[number] = rays;
      node[number] = i;
      number += any(rays);
    }
  };

  /*! Returns the rays that intersect the box, and calls passBoxes() for others. */
  __forceinline vbool<K> intersectBox(const BoxRangesK<K>& box, const vbool<K>& lanes) {
    const vbool<K> active = lanes & visitor.activeRays, hit = active & box.intersects(visitor.sBest);
    if (Visitor::tracksPassedBoxes) {
      const vbool<K> passed = andn(active, hit) & visitor.needsPassedBoxes();
      if (any(passed)) visitor.passBoxes(box.isAbove(rays.descends[2]), passed);
    }
    return hit;
  }

  void intersectTile(int level, uint32_t m, const vbool<K>& lanes) {
    Tile& tile = tileOf(level, m);
    const uint32_t number = tile.number;
    if (unlikely(tile.isAboveRoot())) { // all rays intersect the root
      intersectChildren(level, m, number, tile.present, 0, lanes);
      return;
    }
    const Visits children(*this, tile.children, 0, 15u, lanes);
    for (uint32_t n = 0; n < children.number; n++) {
      const uint32_t c = children.node[n];
      const vbool<K> hit = intersectBox(children.box[c], children.lanes[n]);
      if (any(hit)) intersectChildren(level, m, number, 15u, c, hit);
    }
  }

  /*! Visits the grandchildren below child c of a tile. lanes: rays that intersect child c. */
  void intersectChildren(int level, uint32_t m, uint32_t number, uint32_t present, uint32_t c, const vbool<K>& lanes) {
    Tile* tile = &withChildren(level, m, c);
    const Visits visits(*this, tile->grandchildren, 4 * c, present, lanes);
    for (uint32_t n = 0; n < visits.number; n++) {
      const uint32_t i = visits.node[n];
      const vbool<K> hit = intersectBox(visits.box[i], visits.lanes[n]);
      if (none(hit)) continue;
      if (level == last) {
        if (unlikely(!tiles.isDecoded(*tile, number, 4 * c + i))) tile = &withChildren(level, m, c); // may be evicted
        visitor.leaf((const LeafTile&)*tile, m, 4 * c + i, visits.box[i], hit);
      } else intersectTile(level + 2, 16 * m + 4 * c + i, hit);
    }
  }

  __forceinline Tile& tileOf(int level, uint32_t m) {
    return level == last ? (Tile&)visitor.leafTile(m) : tiles.tile(level, m);
  }

  /*! Returns a tile with decoded grandchildren below child c. */
  __forceinline Tile& withChildren(int level, uint32_t m, uint32_t c) {
    if (level == last) {
      LeafTile& tile = visitor.leafTile(m);
      tiles.ensureDecoded(tile, 1u << c);
      return tile;
    }
    Tile& tile = tiles.tile(level, m);
    tiles.ensureDecoded(tile, 1u << c);
    return tile;
  }
};
} // namespace embree::isa::cbvh
