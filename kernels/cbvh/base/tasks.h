// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Parallel loops of builds. */

#include "../embree/scene.h"

namespace embree::isa {
/*! Quads between two progress reports of a task: few enough to cancel quickly, and enough that reports cost no
 *  measurable time. */
static const size_t progressQuads = 1 << 15;

/*! Like parallel_for, but runs a single range without tasks: scenes may have 100,000 geometries of one face. Does
 *  not call closure(range<size_t>) if n is 0. perTask: at least 1; the tasking system may choose other sizes of
 *  ranges. */
template<typename Closure>
inline void forRanges(size_t n, size_t perTask, const Closure& closure) {
  if (n > perTask) parallel_for(size_t(0), n, perTask, closure);
  else if (n) closure(range<size_t>(0, n));
}

/*! Same for parallel_reduce. Returns `none` if n is 0. none: neutral element of `sum`, which must be associative,
 *  because the number of ranges depends on the number of threads. */
template<typename Value, typename Closure, typename Sum>
inline Value reduceRanges(size_t n, size_t perTask, const Value& none, const Closure& closure, const Sum& sum) {
  if (n > perTask) return parallel_reduce(size_t(0), n, perTask, none, closure, sum);
  return n ? closure(range<size_t>(0, n)) : none;
}
} // namespace embree::isa
