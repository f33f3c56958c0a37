// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A ray segment that ascends on every axis, and the boxes of a node's four children beside
 * it. Axes along which the ray descends are mirrored (x -> 1-x, node_tables.h): near planes
 * are lower planes and lane order is front-to-back order. */

#include "local_ray4.h"
#include "node_tables.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! bounds of one node in all lanes, mirrored */
      struct ParentBox
      {
        vfloat4 lower[3], extent[3];

        static __forceinline ParentBox root ()
        {
          ParentBox box;
          for (int k=0; k<3; k++) { box.lower[k] = vfloat4(zero); box.extent[k] = vfloat4(1.0f); }
          return box;
        }
      };

      /*! the four children of a node, mirrored; lane l is child l ^ flip */
      struct ChildBoxes
      {
        vfloat4 lower[3], extent[3];
        vfloat4 sNear;  //!< where the ray's line enters, may lie before the segment
        vfloat4 sFar;   //!< where it leaves, may lie behind the segment

        __forceinline ParentBox parent (size_t lane) const
        {
          ParentBox box;
          for (int k=0; k<3; k++) { box.lower[k] = vfloat4(lower[k][lane]); box.extent[k] = vfloat4(extent[k][lane]); }
          return box;
        }
      };

      struct HitMasks
      {
        size_t hit;    //!< children whose box the segment meets
        size_t passed; //!< children that it only shares x and y with
      };

      struct MirroredRay
      {
        vfloat4 P[3], D[3];        //!< start and direction, D >= 0
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
          selectTables();
        }

        __forceinline int flipXY () const { return flip[0] | (flip[1] << 1); }

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

        /*! the four children of a node, codec/node.h */
        __forceinline void decode (uint32_t word, const ParentBox& parent, ChildBoxes& c) const
        {
          for (int axis=0; axis<2; axis++) {
            const vfloat4 n = vfloat4::load(nearPlane[axis][(word >> nearShift[axis]) & planePairMask]);
            const vfloat4 f = vfloat4::load(farPlane [axis][(word >> farShift [axis]) & planePairMask]);
            c.lower[axis] = madd(n,parent.extent[axis],parent.lower[axis]);
            c.extent[axis] = madd(f,parent.extent[axis],parent.lower[axis]) - c.lower[axis];
          }
          const vfloat4 z0 = vfloat4::load(zPair[(word >> zShift0) & 63]);
          const vfloat4 z1 = vfloat4::load(zPair[(word >> zShift1) & 63]);
          const vfloat4 n = vfloat4(_mm_movelh_ps(z0,z1)), f = vfloat4(_mm_movehl_ps(z1,z0));
          c.lower[2] = madd(n,parent.extent[2],parent.lower[2]);
          c.extent[2] = madd(f,parent.extent[2],parent.lower[2]) - c.lower[2];
        }

      private:
        __forceinline void selectTables ()
        {
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
      };
    }
  }
}
