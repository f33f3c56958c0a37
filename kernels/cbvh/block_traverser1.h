// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Walk of one ray through the quadtree of one block, front to back.
 *
 * Everything is mirrored so that the ray ascends on every axis (node_tables.h):
 * near planes are lower planes and lane order is front-to-back order. Children of
 * a node are decoded and tested four at a time; the open part of each level is a
 * mask and the decoded boxes, so the depth of the tree is all the stack there is.
 *
 * The traverser knows nothing of leaves. It hands them over in groups, up to four
 * children of a node of the last level. */

#include "local_ray.h"
#include "node_codec.h"
#include "node_tables.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! the four children of a node, mirrored; lane l is child l ^ flip */
      struct ChildBoxes
      {
        vfloat4 lower[3], extent[3];
        vfloat4 sNear;  //!< where the ray's line enters, may lie before the segment
        vfloat4 sFar;   //!< where it leaves, may lie behind the segment
      };

      struct HitMasks
      {
        size_t hit;    //!< children whose box the segment meets
        size_t passed; //!< children that it only shares x and y with
      };

      /*! ray segment in mirrored coordinates */
      struct MirroredRay
      {
        vfloat4 P[3], D[3];      //!< start and direction, D >= 0
        vfloat4 Pnear[3], Pfar[3]; //!< start, moved by the ray's epsilon to widen bounds
        vfloat4 rcpD[3];
        float epsilonZ;
        int flip[3];

        const float (*nearPlane[2])[4];
        const float (*farPlane[2])[4];
        const float (*zPair)[4];
        int nearShift[2], farShift[2], zShift0, zShift1;

        __forceinline MirroredRay (const LocalRay& ray)
        {
          const vfloat4 d = ray.P1 - ray.P0;
          const vboolf4 down = d < vfloat4(zero);
          const vfloat4 m0 = select(down,vfloat4(1.0f)-ray.P0,ray.P0);
          const vfloat4 md = abs(d);
          const vfloat4 n = m0 + ray.epsilon, f = m0 - ray.epsilon;
          const vfloat4 r = vfloat4(1.0f)/max(md,vfloat4(1e-18f));
          const size_t mask = movemask(down);
          P[0] = shuffle<0>(m0); P[1] = shuffle<1>(m0); P[2] = shuffle<2>(m0);
          D[0] = shuffle<0>(md); D[1] = shuffle<1>(md); D[2] = shuffle<2>(md);
          Pnear[0] = shuffle<0>(n); Pnear[1] = shuffle<1>(n); Pnear[2] = shuffle<2>(n);
          Pfar[0] = shuffle<0>(f); Pfar[1] = shuffle<1>(f); Pfar[2] = shuffle<2>(f);
          rcpD[0] = shuffle<0>(r); rcpD[1] = shuffle<1>(r); rcpD[2] = shuffle<2>(r);
          epsilonZ = ray.epsilon[2];
          for (int k=0; k<3; k++) flip[k] = (mask >> k) & 1;

          for (int axis=0; axis<2; axis++) {
            nearPlane[axis] = nodeTables.nearPlane[axis][flip[axis]];
            farPlane [axis] = nodeTables.farPlane [axis][flip[axis]];
            nearShift[axis] = flip[axis] ? upperShift(axis) : lowerShift(axis);
            farShift [axis] = flip[axis] ? lowerShift(axis) : upperShift(axis);
          }
          zPair = nodeTables.zPair[flip[0]][flip[2]];
          zShift0 = zShift + (flip[1] ? 2*zBits : 0);
          zShift1 = zShift + (flip[1] ? 0 : 2*zBits);
        }

        __forceinline int flipXY() const { return flip[0] | (flip[1] << 1); }

        /*! tests the four boxes against the segment up to sBest */
        __forceinline HitMasks intersect (ChildBoxes& c, float sBest) const
        {
          const vfloat4 nx = (c.lower[0]-Pnear[0])*rcpD[0], fx = (c.lower[0]+c.extent[0]-Pfar[0])*rcpD[0];
          const vfloat4 ny = (c.lower[1]-Pnear[1])*rcpD[1], fy = (c.lower[1]+c.extent[1]-Pfar[1])*rcpD[1];
          const vfloat4 nz = (c.lower[2]-Pnear[2])*rcpD[2], fz = (c.lower[2]+c.extent[2]-Pfar[2])*rcpD[2];
          const vfloat4 nxy = max(nx,ny), fxy = min(fx,fy);
          c.sNear = max(nxy,nz);
          c.sFar = min(fxy,fz);
          HitMasks masks;
          masks.hit = movemask(max(c.sNear,vfloat4(zero)) <= min(c.sFar,vfloat4(sBest)));
          masks.passed = movemask(max(nxy,vfloat4(zero)) <= min(fxy,vfloat4(sBest))) & ~masks.hit;
          return masks;
        }

        /*! whether the ray goes over a box that it shares x and y with but does not meet,
         *  in the frame, not mirrored */
        __forceinline bool isAbove (const ChildBoxes& c, size_t lane) const
        {
          const float x0 = (c.lower[0][lane]-Pnear[0][0])*rcpD[0][0], y0 = (c.lower[1][lane]-Pnear[1][0])*rcpD[1][0];
          const float z1 = (c.lower[2][lane]+c.extent[2][lane]-Pfar[2][0])*rcpD[2][0];
          return (z1 < max(max(x0,y0),0.0f)) != (flip[2] != 0);
        }

        __forceinline void decode (uint32_t node, const vfloat4 lower[3], const vfloat4 extent[3], ChildBoxes& c) const
        {
          for (int axis=0; axis<2; axis++) {
            const vfloat4 n = vfloat4::load(nearPlane[axis][(node >> nearShift[axis]) & planePairMask]);
            const vfloat4 f = vfloat4::load(farPlane [axis][(node >> farShift [axis]) & planePairMask]);
            c.lower[axis] = madd(n,extent[axis],lower[axis]);
            c.extent[axis] = madd(f,extent[axis],lower[axis]) - c.lower[axis];
          }
          const vfloat4 z0 = vfloat4::load(zPair[(node >> zShift0) & 63]);
          const vfloat4 z1 = vfloat4::load(zPair[(node >> zShift1) & 63]);
          const vfloat4 n = vfloat4(_mm_movelh_ps(z0,z1)), f = vfloat4(_mm_movehl_ps(z1,z0));
          c.lower[2] = madd(n,extent[2],lower[2]);
          c.extent[2] = madd(f,extent[2],lower[2]) - c.lower[2];
        }
      };

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

      /*! Walks the tree. A Group has
       *
       *    void decode (uint32_t word, uint32_t m, const vfloat4 lower[3], const vfloat4 extent[3], ChildBoxes& c)
       *      boxes of four leaves, from their parent's word and box.
       *    bool leaves (const ChildBoxes& c, const HitMasks& masks, const ChildOrder& order, uint32_t m)
       *      up to four leaves of one parent; lane l is leaf 4m + (l ^ flip). True ends
       *      the walk.
       *    bool passedAbove (bool above)
       *      only if wantsPassed(): the ray went over (under) a whole subtree.
       *    bool wantsPassed ()
       *    float sBest
       *      nodes that begin behind it are skipped; may be lowered.
       *
       *  Events come in front-to-back order. */
      template<typename Group>
      __forceinline bool traverseBlock (const MirroredRay& ray, const uint32_t* nodes, const uint32_t nodeLevels, Group& group)
      {
        const int flip = ray.flipXY();
        ChildBoxes stack[maxLevel];
        struct Open { unsigned hit, passed; uint32_t first; ChildOrder order; };
        Open open[maxLevel];

        if (unlikely(nodeLevels == 0))
        {
          ChildBoxes& c = stack[0];
          for (int k=0; k<3; k++) { c.lower[k] = vfloat4(zero); c.extent[k] = vfloat4(1.0f); }
          HitMasks masks = ray.intersect(c,group.sBest);
          if (masks.hit == 0) return false;
          masks.hit = size_t(1) << flip; // lane of child 0, all four hold the root
          masks.passed = 0;
          return group.leaves(c,masks,ChildOrder(c,masks.hit),uint32_t(0));
        }

        vfloat4 lower[3], extent[3];
        for (int k=0; k<3; k++) { lower[k] = vfloat4(zero); extent[k] = vfloat4(1.0f); }
        uint32_t depth = 0, m = 0;
        while (true)
        {
          ChildBoxes& c = stack[depth];
          const uint32_t word = nodes[nodesOfLevels(depth)+m];
          if (depth+1 == nodeLevels) group.decode(word,m,lower,extent,c);
          else ray.decode(word,lower,extent,c);
          const HitMasks masks = ray.intersect(c,group.sBest);
          const ChildOrder order(c,masks.hit | masks.passed);
          open[depth] = Open{ unsigned(order.toOrder(masks.hit)), unsigned(order.toOrder(masks.passed)), 4*m, order };
          if (depth+1 == nodeLevels) {
            if ((masks.hit | (group.wantsPassed() ? masks.passed : 0)) && group.leaves(c,masks,order,m)) return true;
            open[depth].hit = open[depth].passed = 0;
          }

          /* next child in front-to-back order that is not behind the closest hit */
          while (true)
          {
            Open& o = open[depth];
            const unsigned events = group.wantsPassed() ? o.hit | o.passed : o.hit;
            if (events == 0) {
              if (depth == 0) return false;
              depth--;
              continue;
            }
            const size_t i = bsf(size_t(events));
            const size_t lane = o.order.lane(i);
            const ChildBoxes& p = stack[depth];
            const unsigned before = (2u << i) - 1;
            const bool isHit = (o.hit >> i) & 1;
            o.hit &= ~before;
            o.passed &= ~before;
            if (!isHit) {
              if (group.passedAbove(ray.isAbove(p,lane))) return true;
              continue;
            }
            if (unlikely(p.sNear[lane] > group.sBest)) continue;
            for (int k=0; k<3; k++) { lower[k] = vfloat4(p.lower[k][lane]); extent[k] = vfloat4(p.extent[k][lane]); }
            m = o.first + (uint32_t(lane) ^ uint32_t(flip));
            depth++;
            break;
          }
        }
      }
    }
  }
}
