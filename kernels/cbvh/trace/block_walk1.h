// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Walk of one ray through the quadtree of one block, front to back, two levels at a time.
 *
 * The open part of each tile is a mask, so the depth of the tree is all the stack there is.
 *
 * What a leaf is, and what a ray does there, is the Visitor's: it has
 *
 *    Tile& leafTile (uint32_t m)
 *      the tile of the last level whose grandchildren are leaves 16 m to 16 m + 15.
 *    bool leaf (uint32_t m, uint32_t child, const BoxRanges<16>& ranges)
 *      leaf 16 m + child, whose box the ray meets. True ends the walk.
 *    bool passedAbove (bool above)
 *      only if wantsPassed(): the ray went over (under) a whole subtree.
 *    bool wantsPassed ()
 *    float sBest
 *      nodes that begin behind it are skipped; may be lowered.
 *
 * Calls come in front-to-back order. */

#include "tile_hits.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      template<typename Visitor>
      class BlockWalk1
      {
        const FrameRay& ray;
        BlockTiles& tiles;
        Visitor& visitor;

        struct Level
        {
          TileHits hits; //!< that are still to come
          uint32_t m;    //!< the tile's node
        };
        Level levels[maxLevel/2+1];

      public:
        __forceinline BlockWalk1 (const FrameRay& ray, BlockTiles& tiles, Visitor& visitor)
          : ray(ray), tiles(tiles), visitor(visitor) {}

        /*! what the visitor's calls return: true if one of them ended the walk */
        __forceinline bool run ()
        {
          const int first = tiles.firstLevel(), last = tiles.lastLevel();
          Level* l = levels;
          int level = first;
          l->m = 0;
          open(*l,level == last,level);
          while (true)
          {
            const uint32_t events = l->hits.events(visitor.wantsPassed());
            if (events == 0) {
              if (level == first) return false;
              level -= 2;
              l--;
              continue;
            }
            const uint32_t place = uint32_t(bsf(events)), child = l->hits.grandchild(place);
            if (unlikely(!l->hits.take(place))) {
              if (visitor.passedAbove(isAbove(*l,level == last,level,place,child))) return true;
              continue;
            }
            if (unlikely(l->hits.ranges.sNear[child] > visitor.sBest)) continue;
            if (level == last) {
              if (visitor.leaf(l->m,child,l->hits.ranges)) return true;
              continue;
            }
            level += 2;
            l[1].m = 16*l->m + child;
            l++;
            open(*l,level == last,level);
          }
        }

      private:
        __forceinline void open (Level& l, bool isLast, int level)
        {
          if (isLast) meet(visitor.leafTile(l.m),l.hits);
          else meet(tiles.tile(level,l.m),l.hits);
        }

        template<typename Tile>
        __forceinline void meet (Tile& tile, TileHits& hits)
        {
          const TileHits::Children children(ray,tile,visitor.sBest);
          tiles.need(tile,children.masks.hit);
          hits.set(ray,tile,children,visitor.sBest);
        }

        /*! of a place that is passed */
        __noinline bool isAbove (const Level& l, bool isLast, int level, uint32_t place, uint32_t child)
        {
          if (isLast) return isAbove(visitor.leafTile(l.m),l.hits,place,child);
          return isAbove(tiles.tile(level,l.m),l.hits,place,child);
        }

        template<typename Tile>
        __forceinline bool isAbove (Tile& tile, const TileHits& hits, uint32_t place, uint32_t child)
        {
          if (hits.isChild(place)) return ray.isAbove(tile.children,child >> 2);
          tiles.need(tile,1u << (child >> 2));
          return ray.isAbove(tile.grandchildren,child);
        }
      };
    }
  }
}
