// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Loops of functions that an application may call in its own tasks. */

#include "../../../common/tasking/taskscheduler.h"

namespace embree {
/*! Runs a closure so that its parallel loops complete although the application cancels the task group that the caller
 *  is in. Returns after the closure; passes its exceptions on. */
template<typename Closure>
inline void runIsolated(const Closure& closure) {
#if defined(TASKING_TBB)
  tbb::task_group_context context(tbb::task_group_context::isolated,
                                  tbb::task_group_context::default_traits | tbb::task_group_context::fp_settings);
  tbb::parallel_for(size_t(0), size_t(1), size_t(1), [&](size_t) { closure(); }, context);
#else
  closure();
#endif
}
} // namespace embree
