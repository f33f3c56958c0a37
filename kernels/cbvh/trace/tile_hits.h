// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How a ray meets a tile, and in what order: that of the tree, children along the ray and in each its
 * children along the ray.
 *
 * A place says when something comes: 4 c + i is child i of child c, both counted along the ray. Its node is
 * the place with the bits of the axes flipped along which the ray descends. Places 1 and 2 of four are
 * alternatives, of which overlaps can make a ray meet both: then the one that begins first comes first. */

#include "block_tiles.h"
#include "frame_ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      class TileHits
      {
      public:
        __forceinline TileHits () {}

        /*! places that the ray comes to; passedMask: 0 without those that it passes, else all bits */
        __forceinline uint32_t events (uint32_t passedMask) const { return hit | (passed & passedMask); }

        /*! takes a place out, with what comes before; whether it is a hit */
        __forceinline bool take (uint32_t place)
        {
          const bool isHit = (hit >> place) & 1u;
          const uint32_t behind = ~((2u << place) - 1u);
          hit &= behind;
          passed &= behind;
          return isHit;
        }

        /*! of a place that is no hit: whether a child as a whole is passed */
        __forceinline bool isChild (uint32_t place) const { return !((childHit >> (place >> 2)) & 1u); }

        /*! the grandchild at a place; of a child it has the upper bits */
        __forceinline uint32_t grandchild (uint32_t place) const
        {
          uint32_t p = place;
          if (unlikely(swaps != 0u)) {
            if ((swaps >> (p >> 2)) & 1u && isAlternative(p & 3u)) p ^= 3u;
            if (swaps & childSwap && isAlternative(p >> 2)) p ^= 12u;
          }
          return p ^ flip;
        }

        /*! what it says of four boxes says whose children are of interest, and are met next */
        struct Children
        {
          BoxMasks masks;
          BoxRanges<4> ranges;

          __forceinline Children (const FrameRay& ray, const NodeEntries::Tile& tile, float sBest)
          {
            masks = meetBoxes<vfloat4>(ray,tile.children,sBest,ranges);
            const uint32_t present = likely(tile.present == 0xFFFFu) ? 15u : 1u;
            masks.hit &= present;
            masks.passed &= present;
          }
        };

        __forceinline void set (const FrameRay& ray, const NodeEntries::Tile& tile, const Children& children, float sBest)
        {
          const uint32_t open = nodeTables.allOfFour[children.masks.hit] & tile.present;
          BoxMasks all = { 0u,0u };
          if (likely(open != 0u)) all = meetBoxes<vfloatV>(ray,tile.grandchildren,sBest,ranges);
          const uint32_t first = ray.flipXY();
          flip = first | first << 2;
          swaps = 0u;
          uint32_t places = toPlaces((all.hit & open) | (all.passed & open) << 16,first); // hits, and passed in the upper half

          uint32_t order = first;
          const uint32_t a = 1u^first, b = 2u^first, met = children.masks.hit | children.masks.passed;
          if (unlikely(((met >> a) & (met >> b) & 1u) != 0u) && children.ranges.sNear[b] < children.ranges.sNear[a]) {
            order |= 4u;
            swaps |= childSwap;
            places = (places & 0xF00FF00Fu) | (places & 0x00F000F0u) << 4 | (places & 0x0F000F00u) >> 4;
          }
          childHit = nodeTables.maskInOrder[order][children.masks.hit];

          const uint32_t either = places | places >> 16;
          for (uint32_t rest=either & (either >> 1) & 0x2222u; unlikely(rest != 0u); rest&=rest-1)
          {
            const uint32_t place = uint32_t(bsf(rest));
            if (!(ranges.sNear[grandchild(place+1)] < ranges.sNear[grandchild(place)])) continue;
            swaps |= 1u << (place >> 2);
            const uint32_t bits = 0x10001u << place, differs = (places ^ places >> 1) & bits;
            places ^= differs | differs << 1;
          }
          hit = places & 0xFFFFu;
          passed = places >> 16 | nodeTables.firstOfFour[nodeTables.maskInOrder[order][children.masks.passed]];
        }

        BoxRanges<16> ranges; //!< by grandchild

      private:
        static const uint32_t childSwap = 16u;

        static __forceinline bool isAlternative (uint32_t place) { return place-1u < 2u; }

        /*! two masks of grandchildren as masks of places, nothing swapped */
        static __forceinline uint32_t toPlaces (uint32_t m, uint32_t first)
        {
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

        uint32_t hit, passed; //!< places; a child that is passed as a whole at its first
        uint32_t childHit;    //!< children along the ray whose boxes the ray meets
        uint32_t flip, swaps; //!< swaps: alternatives that are swapped, a bit for each four
      };
    }
  }
}
