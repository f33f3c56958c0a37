// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree
{
  namespace isa
  {
    /*! A task of a build reports progress after so many quads: often enough to cancel, too rarely to cost time. */
    static const size_t progressQuads = 1 << 15;

    /*! Like parallel_for, but without tasks if there is only one range: a scene may have a hundred thousand geometries
     *  of one face. */
    template<typename Closure>
    inline void forRanges (size_t n, size_t perTask, const Closure& closure)
    {
      if (n > perTask) parallel_for(size_t(0),n,perTask,closure);
      else if (n) closure(range<size_t>(0,n));
    }

    /*! As forRanges(), with a reduction. */
    template<typename Value, typename Closure, typename Sum>
    inline Value reduceRanges (size_t n, size_t perTask, const Value& none, const Closure& closure, const Sum& sum)
    {
      if (n > perTask) return parallel_reduce(size_t(0),n,perTask,none,closure,sum);
      return n ? closure(range<size_t>(0,n)) : none;
    }
  }
}
