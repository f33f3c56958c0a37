// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Walk of one ray through the quadtree of one block, front to back.
 *
 * Children of a node are decoded and tested four at a time; the open part of each level is
 * a mask and the decoded boxes, so the depth of the tree is all the stack there is.
 *
 * What a leaf is, and what a ray does there, is the Visitor's: it has
 *
 *    void decode (uint32_t word, uint32_t m, const ParentBox& parent, ChildBoxes& c)
 *      boxes of four leaves, from word m of the last level and their parent's box.
 *    bool leaves (const ChildBoxes& c, const HitMasks& masks, const ChildOrder& order, uint32_t m)
 *      up to four leaves of one parent; lane l is leaf 4m + (l ^ flip). True ends
 *      the walk.
 *    bool passedAbove (bool above)
 *      only if wantsPassed(): the ray went over (under) a whole subtree.
 *    bool wantsPassed ()
 *    float sBest
 *      nodes that begin behind it are skipped; may be lowered.
 *
 * Calls come in front-to-back order. */

#include "mirrored_ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! Order of a node's children along the ray: 0 is first, 3 last, 1 and 2 are
       *  alternatives of which overlaps can make the ray meet both, nearest first.
       *  Masks in order space have bit i for the i-th child of the order. */
      struct ChildOrder
      {
        bool swapped; //!< 0, 2, 1, 3

        __forceinline ChildOrder () {}
        __forceinline ChildOrder (const ChildBoxes& c, size_t mask)
          : swapped(unlikely((mask & 6) == 6) && c.sNear[2] < c.sNear[1]) {}

        __forceinline size_t toOrder (size_t mask) const { return swapped ? (mask & 9) | ((mask & 2) << 1) | ((mask & 4) >> 1) : mask; }
        __forceinline size_t lane (size_t i) const { return swapped && (i == 1 || i == 2) ? 3-i : i; }
      };

      template<typename Visitor>
      class BlockWalk1
      {
        const MirroredRay& ray;
        const uint32_t* nodes;
        const uint32_t nodeLevels;
        Visitor& visitor;

        struct Level
        {
          unsigned hit, passed; //!< children that are still to come, in their order
          uint32_t first;       //!< node of child 0
          ChildOrder order;
        };
        ChildBoxes boxes[maxLevel];
        Level levels[maxLevel];
        uint32_t depth, m;      //!< the node that is opened next
        ParentBox parent;       //!< its box

      public:
        __forceinline BlockWalk1 (const MirroredRay& ray, const uint32_t* nodes, uint32_t nodeLevels, Visitor& visitor)
          : ray(ray), nodes(nodes), nodeLevels(nodeLevels), visitor(visitor), depth(0), m(0), parent(ParentBox::root()) {}

        /*! what the visitor's calls return: true if one of them ended the walk */
        __forceinline bool run ()
        {
          if (unlikely(nodeLevels == 0)) return visitRoot();
          while (true)
          {
            if (open()) return true;
            const Step step = next();
            if (step != DESCEND) return step == ENDED;
          }
        }

      private:
        enum Step { DESCEND, ENDED, EXHAUSTED };

        /*! a block without nodes is one leaf */
        __forceinline bool visitRoot ()
        {
          ChildBoxes& c = boxes[0];
          for (int k=0; k<3; k++) { c.lower[k] = parent.lower[k]; c.extent[k] = parent.extent[k]; }
          HitMasks masks = ray.intersect(c,visitor.sBest);
          if (masks.hit == 0) return false;
          masks.hit = size_t(1) << ray.flipXY(); // lane of child 0, all four hold the root
          masks.passed = 0;
          return visitor.leaves(c,masks,ChildOrder(c,masks.hit),0u);
        }

        /*! decodes and tests the children of a node; true if the visitor ended the walk */
        __forceinline bool open ()
        {
          ChildBoxes& c = boxes[depth];
          const uint32_t word = nodes[nodesOfLevels(depth)+m];
          const bool last = depth+1 == nodeLevels;
          if (last) visitor.decode(word,m,parent,c);
          else ray.decode(word,parent,c);
          const HitMasks masks = ray.intersect(c,visitor.sBest);
          const ChildOrder order(c,masks.hit | masks.passed);
          levels[depth] = Level{ unsigned(order.toOrder(masks.hit)), unsigned(order.toOrder(masks.passed)), 4*m, order };
          if (!last) return false;
          if ((masks.hit | (visitor.wantsPassed() ? masks.passed : 0)) && visitor.leaves(c,masks,order,m)) return true;
          levels[depth].hit = levels[depth].passed = 0;
          return false;
        }

        /*! goes to the next child in front-to-back order that is not behind the closest hit */
        __forceinline Step next ()
        {
          while (true)
          {
            Level& l = levels[depth];
            const unsigned events = visitor.wantsPassed() ? l.hit | l.passed : l.hit;
            if (events == 0) {
              if (depth == 0) return EXHAUSTED;
              depth--;
              continue;
            }
            const size_t i = bsf(size_t(events));
            const size_t lane = l.order.lane(i);
            const ChildBoxes& c = boxes[depth];
            const unsigned before = (2u << i) - 1;
            const bool isHit = (l.hit >> i) & 1;
            l.hit &= ~before;
            l.passed &= ~before;
            if (!isHit) {
              if (visitor.passedAbove(ray.isAbove(c,lane))) return ENDED;
              continue;
            }
            if (unlikely(c.sNear[lane] > visitor.sBest)) continue;
            parent = c.parent(lane);
            m = l.first + (uint32_t(lane) ^ uint32_t(ray.flipXY()));
            depth++;
            return DESCEND;
          }
        }
      };
    }
  }
}
