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

      /*! Whether rays meet the bounds of a block between tNear and tFar, which is not raw: most that do not meet a group do not, and
       *  nothing is decoded for them. */
      template<typename Real>
      __forceinline auto meetsBounds (const VertRayAxes<Real>& ray, const VertHeader* block, Real tNear, Real tFar) -> decltype(tNear <= tFar)
      {
        VertAxes axes;
        setAxes(block,axes);
        const int m = axes.axis;
        const float step = float(reachStep(block->boxForm))*vertSpacing(block->word);
        auto clip = [&](const Real& lower, const Real& upper, const Real& rcp) {
          const Real a = lower*rcp, b = upper*rcp;
          tNear = max(tNear,min(a,b));
          tFar = min(tFar,max(b,a)); // not (a,b): the compiler would make one branch of both
        };
        for (int i=0; i<2; i++)
        {
          const int k = axisAfter(m,1+i);
          const Real from = Real(axes.origin[k])-ray.org[k], slack = boxSlack(ray.org[k],axes.origin[k],axes.extent[k]);
          clip(from-slack,(from + Real(float(reachOf(block->reach,i))*step))+slack,ray.rcp[k]);
        }
        const ShearedRay<Real> sheared(ray,axes);
        clip((Real(float(reachOf(block->reach,2))*step)-sheared.org)-sheared.error,(Real(float(reachOf(block->reach,3))*step)-sheared.org)+sheared.error,sheared.rcp);
        return tNear <= tFar;
      }
    }
  }
}
