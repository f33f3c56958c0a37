// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays and the boxes of a block of cVERT, and its bounds. They only cull: planes are exact, and are widened by
 * what the test of triangles may round, some ulps of the distance to the farthest plane. Numbers are floats,
 * of one ray, or vectors, of the rays of a packet. */

#include "axes.h"
#include "ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! ulps that the sheared vertices, the boxes and the ray's distances to them may be off
       *  together: a difference is off by a half, a shear by three halves, a plane's distance
       *  by three, each of the two. */
      static constexpr float slackUlps = 8.0f;

      /*! the same of the sheared axis, where the ray's start and its direction are sums of three */
      static constexpr float shearedSlackUlps = 16.0f;

      /*! The ray along a block's sheared coordinate, from the block's origin. */
      template<typename Real>
      struct ShearedRay
      {
        Real org, rcp, error;

        __forceinline ShearedRay () {}

        __forceinline ShearedRay (const VertRayAxes<Real>& ray, const VertAxes& axes)
        {
          Real dir(0.0f), sum(0.0f);
          org = Real(0.0f);
          for (int k=0; k<3; k++)
          {
            const Real shear(axes.shear[k]), distance = ray.org[k]-Real(axes.origin[k]);
            org = org + shear*distance;
            dir = dir + shear*ray.dir[k];
            sum = sum + abs(shear)*(abs(distance) + Real(axes.extent[k]));
          }
          rcp = reciprocal(dir,ray.largest);
          error = Real(shearedSlackUlps*floatUlp)*sum;
        }
      };

      /*! what is to be added to planes of a world axis */
      template<typename Real>
      __forceinline Real slackOf (const VertRayAxes<Real>& ray, int k, float origin, float extent) {
        return Real(slackUlps*floatUlp)*(abs(Real(origin)-ray.org[k]) + Real(extent));
      }

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
          const Real from = Real(axes.origin[k])-ray.org[k], slack = slackOf(ray,k,axes.origin[k],axes.extent[k]);
          clip(from-slack,(from + Real(float(reachOf(block->reach,i))*step))+slack,ray.rcp[k]);
        }
        const ShearedRay<Real> sheared(ray,axes);
        clip((Real(float(reachOf(block->reach,2))*step)-sheared.org)-sheared.error,(Real(float(reachOf(block->reach,3))*step)-sheared.org)+sheared.error,sheared.rcp);
        return tNear <= tFar;
      }
    }
  }
}
