// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How a ray crosses the four leaves of a group of cLEAF, codec/crossing.h, at once and
 * mirrored. */

#include "block_visitor1.h"
#include "group_patches4.h"
#include "../codec/crossing.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      struct PatchCrossing4
      {
        vfloat4 s0, s1;        //!< entry and exit, within the segment
        vfloat4 u0, v0, u1, v1;
        vfloat4 f0, f1;        //!< z of the ray over the patch, mirrored
        vfloat4 saddle;        //!< f(k) = f0 + k (f1-f0) + saddle k (1-k), k from 0 to 1
        size_t above0, above1; //!< side at entry and exit, in the frame
        size_t changes, nearEntry, near, started, ended; //!< see LeafEvent
        size_t solid, empty;

        __forceinline PatchCrossing4 (const LocalRay& local, const MirroredRay& ray, const ChildBoxes& c, const GroupPatches& patch)
          : solid(patch.solid), empty(patch.empty)
        {
          s0 = max(c.sNear,vfloat4(zero));
          s1 = min(c.sFar,vfloat4(one));
          auto position = [&](const vfloat4& s, int axis, const vfloat4& rcp) {
            return clamp((madd(s,ray.D[axis],ray.P[axis])-c.lower[axis])*rcp,vfloat4(zero),vfloat4(one));
          };
          u0 = position(s0,0,patch.rcpX); v0 = position(s0,1,patch.rcpY);
          u1 = position(s1,0,patch.rcpX); v1 = position(s1,1,patch.rcpY);
          f0 = madd(s0,ray.D[2],ray.P[2]) - patch.z(u0,v0);
          f1 = madd(s1,ray.D[2],ray.P[2]) - patch.z(u1,v1);

          const vboolf4 inside0 = startsInside(local,c), inside1 = endsInside(local,c);
          started = movemask(inside0);
          ended = movemask(inside1);
          saddle = patch.bin*patch.twist*(u1-u0)*(v1-v0);
          const vfloat4 reach = patch.reach + vfloat4(ray.epsilonZ);
          const vboolf4 change = (f0 < vfloat4(zero)) != (f1 < vfloat4(zero));
          changes = movemask(change);
          nearEntry = movemask(abs(f0) <= reach);
          near = movemask((min(abs(f0),abs(f1)) <= madd(vfloat4(0.25f),abs(saddle),reach)) | change);

          /* mirrored, a ray enters through lower and leaves through upper faces */
          const vfloat4 lowerFace = (c.lower[2]-ray.Pnear[2])*ray.rcpD[2], upperFace = (c.lower[2]+c.extent[2]-ray.Pfar[2])*ray.rcpD[2];
          const vboolf4 below0 = (f0 < vfloat4(zero)) | ((lowerFace >= c.sNear) & !inside0);
          const vboolf4 up1 = (f1 >= vfloat4(zero)) | ((upperFace <= c.sFar) & !inside1);
          const size_t flip = ray.flip[2] ? 15 : 0;
          above0 = movemask(!below0) ^ flip;
          above1 = movemask(up1) ^ flip;
        }

        __forceinline LeafEvent event (size_t i) const
        {
          auto is = [i](size_t mask) { return bool((mask >> i) & 1); };
          LeafEvent e;
          e.enter = is(above0) ? sideAbove : sideBelow;
          e.leave = is(above1) ? sideAbove : sideBelow;
          e.changes = is(changes);
          e.nearEntry = is(nearEntry);
          e.near = is(near);
          e.started = is(started);
          e.ended = is(ended);
          e.solid = is(solid);
          e.empty = is(empty);
          return e;
        }

        /*! s where f changes sign */
        __forceinline float root (size_t i) const {
          return s0[i] + parabolaRoot(Parabola<float>{f0[i],f1[i],saddle[i]})*(s1[i]-s0[i]);
        }
      };
    }
  }
}
