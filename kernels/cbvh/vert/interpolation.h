// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Interpolation between the ends of a motion's segment. */

#include "../base/vectors.h"
#include "tables.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      struct Between
      {
        const vfloatV before, after;
        __forceinline explicit Between (float fraction) : before(1.0f-fraction), after(fraction) {}

        /*! The floats of Embree's lerp, and therefore of its own kernels. */
        __forceinline vfloatV operator() (const vfloatV& a, const vfloatV& b) const { return madd(before,a,after*b); }

        /*! `count` is rounded up to vectors. All arrays must be aligned to vectors. */
        __forceinline void set (const float* a, const float* b, uint32_t count, float* out) const {
          for (uint32_t l=0; l<count; l+=vectorWidth)
            vfloatV::store(out+l,(*this)(vfloatV::load(a+l),vfloatV::load(b+l)));
        }
      };
    }
  }
}
