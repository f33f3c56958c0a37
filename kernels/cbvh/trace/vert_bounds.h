// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays and the boxes of a block of cVERT, and its bounds. They only cull: planes are exact, and are widened by
 * what the test of triangles may round, some ulps of the distance to the farthest plane. Numbers are floats,
 * of one ray, or vectors, of the rays of a packet. */

#include "vert_cache.h"
#include "vert_ray.h"
#include "../codec/vert_block.h"

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

        __forceinline ShearedRay (const VertRayAxes<Real>& ray, const VertHeader* block)
        {
          const int m = shearedAxis(block->boxForm);
          const float extent = extentOf(block);
          Real dir(0.0f), sum(0.0f);
          org = Real(0.0f);
          for (int i=2; i>=0; i--)
          {
            const int k = m+i < 3 ? m+i : m+i-3;
            const float slope = i == 0 ? 1.0f : float(shearSlope(block->boxForm,i))*(1.0f/16.0f);
            const Real distance = ray.org[k]-Real(block->origin[k]);
            org = org + Real(slope)*distance;
            dir = dir + Real(slope)*ray.dir[k];
            sum = sum + Real(std::fabs(slope))*(abs(distance) + Real(extent));
          }
          rcp = reciprocal(dir,ray.largest);
          error = Real(shearedSlackUlps*floatUlp)*sum;
        }

        /*! the same of a block whose boxes are decoded */
        __forceinline ShearedRay (const VertRayAxes<Real>& ray, const VertBoxes& boxes)
        {
          Real dir(0.0f), sum(0.0f);
          org = Real(0.0f);
          for (int k=0; k<3; k++)
          {
            const Real shear(boxes.shear[k]), distance = ray.org[k]-Real(boxes.origin[k]);
            org = org + shear*distance;
            dir = dir + shear*ray.dir[k];
            sum = sum + abs(shear)*(abs(distance) + Real(boxes.extent[k]));
          }
          rcp = reciprocal(dir,ray.largest);
          error = Real(shearedSlackUlps*floatUlp)*sum;
        }

        /*! of a packed block from its origin, at least */
        static __forceinline float extentOf (const VertHeader* block) { return float(maxExtent)*vertSpacing(block->word); }
      };

      /*! what is to be added to planes of a world axis */
      template<typename Real>
      __forceinline Real slackOf (const VertRayAxes<Real>& ray, int k, float origin, float extent) {
        return Real(slackUlps*floatUlp)*(abs(Real(origin)-ray.org[k]) + Real(extent));
      }

      /*! Whether rays meet the bounds of a block between tNear and tFar, which is not raw: most that do not meet a group do not, and
       *  nothing is decoded for them. */
      template<typename Real>
      __forceinline auto meetsBounds (const VertRayAxes<Real>& ray, const ShearedRay<Real>& sheared, const VertHeader* block, Real tNear, Real tFar) -> decltype(tNear <= tFar)
      {
        const int m = shearedAxis(block->boxForm);
        const float step = float(reachStep(block->boxForm))*vertSpacing(block->word), extent = ShearedRay<Real>::extentOf(block);
        auto clip = [&](const Real& lower, const Real& upper, const Real& rcp) {
          const Real a = lower*rcp, b = upper*rcp;
          tNear = max(tNear,min(a,b));
          tFar = min(tFar,max(a,b));
        };
        for (int i=0; i<2; i++)
        {
          const int k = m+1+i < 3 ? m+1+i : m+1+i-3;
          const Real from = Real(block->origin[k])-ray.org[k], slack = slackOf(ray,k,block->origin[k],extent);
          clip(from-slack,(from + Real(float(reachOf(block->reach,i))*step))+slack,ray.rcp[k]);
        }
        clip((Real(float(reachOf(block->reach,2))*step)-sheared.org)-sheared.error,(Real(float(reachOf(block->reach,3))*step)-sheared.org)+sheared.error,sheared.rcp);
        return tNear <= tFar;
      }
    }
  }
}
