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

      /*! Bounds of a block from its origin: on two axes up to a plane, on the sheared one between two. */
      struct BlockBounds : public VertAxes
      {
        float upper[2], sheared[2];
        float slack[3];             //!< by axis: what they may be too small by
      };

      /*! Whether rays meet such bounds between tNear and tFar: most that do not meet a group do not, and nothing is decoded for them. */
      template<typename Real>
      __forceinline auto meetsBounds (const VertRayAxes<Real>& ray, const BlockBounds& bounds, Real tNear, Real tFar) -> decltype(tNear <= tFar)
      {
        const int m = bounds.axis;
        auto clip = [&](const Real& lower, const Real& upper, const Real& rcp) {
          const Real a = lower*rcp, b = upper*rcp;
          tNear = max(tNear,min(a,b));
          tFar = min(tFar,max(b,a)); // not (a,b): the compiler would make one branch of both
        };
        for (int i=0; i<2; i++)
        {
          const int k = axisAfter(m,1+i);
          const Real from = Real(bounds.origin[k])-ray.org[k], slack = boxSlack(ray.org[k],bounds.origin[k],bounds.extent[k]) + Real(bounds.slack[k]);
          clip(from-slack,(from + Real(bounds.upper[i]))+slack,ray.rcp[k]);
        }
        const ShearedRay<Real> sheared(ray,bounds);
        const Real slack = sheared.error + Real(bounds.slack[m]);
        clip((Real(bounds.sheared[0])-sheared.org)-slack,(Real(bounds.sheared[1])-sheared.org)+slack,sheared.rcp);
        return tNear <= tFar;
      }

      /*! of a block that is not raw */
      template<typename Real>
      __forceinline auto meetsBounds (const VertRayAxes<Real>& ray, const VertHeader* block, Real tNear, Real tFar) -> decltype(tNear <= tFar)
      {
        BlockBounds bounds;
        setShear(block->boxForm,true,bounds);
        const VertSpacing spacing = spacingOf(block->word,block->corners);
        const float step = float(reachStep(block->boxForm)), sheared = step*spacing.at[bounds.axis];
        for (int i=0; i<2; i++) {
          bounds.upper[i] = float(cvert::reachOf(block->reach,i))*step*spacing.at[axisAfter(bounds.axis,1+i)];
          bounds.sheared[i] = float(cvert::reachOf(block->reach,2+i))*sheared;
        }
        const float extent = extentOfBounds(bounds.upper[0],bounds.upper[1],bounds.sheared[0],bounds.sheared[1]);
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
