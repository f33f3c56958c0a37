// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays and the boxes of a block of cVERT, and its bounds. They only cull: planes are exact, and are widened as rule.h
 * says. Numbers are floats, of one ray, or vectors, of the rays of a packet. */

#include "axes.h"
#include "ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! The ray along a block's sheared coordinate, from the block's origin. */
      template<typename Real>
      struct ShearedRay
      {
        Real org, rcp, error;

        __forceinline ShearedRay () {}

        __forceinline ShearedRay (const VertRayAxes<Real>& ray, const VertAxes& axes)
        {
          ShearedCoordinate<Real> along = noShearedCoordinate<Real>();
          for (int k=0; k<3; k++) along = addSheared(along,ray.org[k],ray.dir[k],axes.origin[k],axes.extent[k],axes.shear[k]);
          org = along.org;
          rcp = directionReciprocal(along.dir,ray.largest);
          error = shearedSlack(along.size);
        }
      };

      struct BlockBounds : public VertAxes, public BlockReach
      {
        float slack[3];             //!< by axis: what they may be too small by
      };

      /*! Whether rays meet such bounds between tNear and tFar: most that do not meet a group do not, and nothing is decoded for them. */
      template<typename Real>
      __forceinline auto meetsBounds (const VertRayAxes<Real>& ray, const BlockBounds& bounds, Real tNear, Real tFar) -> decltype(tNear <= tFar)
      {
        const int m = bounds.axis;
        RayInterval<Real> interval = { tNear,tFar };
        for (int i=0; i<2; i++)
        {
          const int k = axisAfter(m,1+i);
          const Real from = Real(bounds.origin[k])-ray.org[k], slack = boxSlack(ray.org[k],bounds.origin[k],bounds.extent[k]) + Real(bounds.slack[k]);
          interval = clipped(interval,from-slack,(from + Real(bounds.upper[i]))+slack,ray.rcp[k]);
        }
        const ShearedRay<Real> sheared(ray,bounds);
        const Real slack = sheared.error + Real(bounds.slack[m]);
        interval = clipped(interval,(Real(bounds.sheared[0])-sheared.org)-slack,(Real(bounds.sheared[1])-sheared.org)+slack,sheared.rcp);
        return interval.from <= interval.to;
      }

      /*! of a block that is not raw */
      template<typename Real>
      __forceinline auto meetsBounds (const VertRayAxes<Real>& ray, const VertHeader* block, Real tNear, Real tFar) -> decltype(tNear <= tFar)
      {
        BlockBounds bounds;
        setShear(block->boxForm,true,bounds);
        static_cast<BlockReach&>(bounds) = reachOfBlock(block->boxForm,block->reach,reachStep(block->boxForm),spacingOf(block->word,block->corners));
        const float extent = extentOfReach(bounds);
        for (int k=0; k<3; k++) {
          bounds.origin[k] = block->origin[k];
          bounds.extent[k] = extent;
        }
        for (float& slack : bounds.slack) slack = 0.0f;
        return meetsBounds<Real>(ray,bounds,tNear,tFar);
      }
    }
  }
}
