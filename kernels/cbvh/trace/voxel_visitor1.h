// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cVOXEL: boxes. */

#include "block_visitor1.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! cVOXEL: the ray hits a leaf where it enters its box. A ray that starts inside
       *  a box does not hit that box: it left, or was left behind by, that surface. */
      template<typename RayType>
      struct VoxelVisitor1 : public BlockVisitor1<RayType>
      {
        using BlockVisitor1<RayType>::BlockVisitor1;

        __forceinline bool leaves (const ChildBoxes& c, const HitMasks& masks, const ChildOrder&, uint32_t m)
        {
          const MirroredRay& ray = this->mirrored;
          vboolf4 valid = laneMask(masks.hit) & !startsInside(this->local,c);
          if (none(valid)) return false;
          const vfloat4 s = max(c.sNear,vfloat4(zero));
          const vfloat4 u = clamp((madd(s,ray.D[0],ray.P[0])-c.lower[0])/c.extent[0],vfloat4(zero),vfloat4(one));
          const vfloat4 v = clamp((madd(s,ray.D[1],ray.P[1])-c.lower[1])/c.extent[1],vfloat4(zero),vfloat4(one));
          while (any(valid))
          {
            const size_t i = select_min(valid,s);
            if (this->reportHit(LeafHit{s[i],this->child(m,i),u[i],v[i],0.0f,0.0f,sideUnknown}))
              return IsAnyHit<RayType>::value;
            clear(valid,i);
            valid &= s <= vfloat4(this->sBest);
          }
          return false;
        }
      };
    }
  }
}
