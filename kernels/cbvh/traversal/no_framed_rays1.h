// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single rays of a library without the paper's representations, framed/framed_rays1.h. */

#include "../embree/ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      struct FramedRay
      {
        __forceinline explicit FramedRay (float) {}
        static __forceinline bool isFramed (size_t) { return false; }
        __forceinline void setEnter (float) {}
        template<typename RayType>
        __forceinline bool intersect (RayType&, IntersectContext*, const void*) { return false; }
        __forceinline float end (float tfar) const { return tfar; }
      };
    }
  }
}
