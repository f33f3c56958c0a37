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
 * The traverser knows nothing of leaves. Whenever up to four children of a node
 * of the last level are hit it hands them over as a group. */

#include "local_ray.h"
#include "node_tables.h"

namespace embree
{
  namespace cbvh
  {
    extern const NodeTables nodeTables;
  }

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

        __forceinline void intersect (ChildBoxes& c) const
        {
          const vfloat4 nx = (c.lower[0]-Pnear[0])*rcpD[0], fx = (c.lower[0]+c.extent[0]-Pfar[0])*rcpD[0];
          const vfloat4 ny = (c.lower[1]-Pnear[1])*rcpD[1], fy = (c.lower[1]+c.extent[1]-Pfar[1])*rcpD[1];
          const vfloat4 nz = (c.lower[2]-Pnear[2])*rcpD[2], fz = (c.lower[2]+c.extent[2]-Pfar[2])*rcpD[2];
          c.sNear = max(max(nx,ny),nz);
          c.sFar = min(min(fx,fy),fz);
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

      /*! Group is called as group(boxes, mask, m) with the mask of lanes hit; lane l is
       *  node (or leaf, or group of quads) 4m + (l ^ flip) of its level. It returns
       *  true to end the walk and may lower sBest. */
      template<typename Group>
      __forceinline bool traverseBlock (const MirroredRay& ray, const uint32_t* nodes, const uint32_t nodeLevels, float& sBest, const Group& group)
      {
        const int flip = ray.flipXY();
        ChildBoxes stack[maxLevel];
        unsigned open[maxLevel];
        uint32_t index[maxLevel]; //!< of the first child of the level's open node

        if (unlikely(nodeLevels == 0))
        {
          ChildBoxes& c = stack[0];
          for (int k=0; k<3; k++) { c.lower[k] = vfloat4(zero); c.extent[k] = vfloat4(1.0f); }
          ray.intersect(c);
          const vboolf4 hit = max(c.sNear,vfloat4(zero)) <= min(c.sFar,vfloat4(sBest));
          return movemask(hit) && group(c,size_t(1) << flip,uint32_t(0));
        }

        vfloat4 lower[3], extent[3];
        for (int k=0; k<3; k++) { lower[k] = vfloat4(zero); extent[k] = vfloat4(1.0f); }
        uint32_t depth = 0, m = 0;
        while (true)
        {
          ChildBoxes& c = stack[depth];
          ray.decode(nodes[nodesOfLevels(depth)+m],lower,extent,c);
          ray.intersect(c);
          const vboolf4 hit = max(c.sNear,vfloat4(zero)) <= min(c.sFar,vfloat4(sBest));
          size_t mask = movemask(hit);
          if (depth+1 == nodeLevels) {
            if (mask && group(c,mask,m)) return true;
            mask = 0;
          }
          open[depth] = unsigned(mask);
          index[depth] = 4*m;

          /* next child in front-to-back order that is not behind the closest hit */
          while (true)
          {
            while (open[depth] == 0) {
              if (depth == 0) return false;
              depth--;
            }
            const size_t lane = bsf(size_t(open[depth]));
            open[depth] &= open[depth]-1;
            const ChildBoxes& p = stack[depth];
            if (unlikely(p.sNear[lane] > sBest)) continue;
            for (int k=0; k<3; k++) { lower[k] = vfloat4(p.lower[k][lane]); extent[k] = vfloat4(p.extent[k][lane]); }
            m = index[depth] + (uint32_t(lane) ^ uint32_t(flip));
            depth++;
            break;
          }
        }
      }
    }
  }
}
