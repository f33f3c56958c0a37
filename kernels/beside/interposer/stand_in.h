// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What rays find in a scene in place of a geometry: a user geometry whose user data is one of these. */

#include "real.h"

#include <atomic>
#include <cbvh/cbvh.h>
#include <cstddef>
#include <cstdint>

namespace interposer {

struct StandIn
{
  CbvhGroup group;               // NULL until it is built
  RTCGeometry original;          // the application's
  void* userData;                // the application's, as the original has it
  RTCFilterFunctionN intersectFilter, occludedFilter;
  bool takesArgumentFilters;     // rtcSetGeometryEnableFilterFunctionFromArguments
};

/* All of them lie in one range of addresses, so that it takes two comparisons to tell the user data of ours from an
 * application's. A thread may ask while another makes the first stand-in: readers read the size first, and it is 0 until
 * begin is stored. */
struct StandInRange
{
  std::atomic<uintptr_t> begin, size;
};
extern StandInRange standInRange;

inline StandIn* asStandIn(void* userData)
{
  const uintptr_t size = standInRange.size.load(std::memory_order_acquire);
  return uintptr_t(userData) - standInRange.begin.load(std::memory_order_relaxed) < size ? (StandIn*)userData : nullptr;
}

/* NULL where there is no more room. */
StandIn* newStandIn();
void deleteStandIn(StandIn* standIn);

/* Whether there has been any: until then queries go to Embree as they are. */
bool hasStandIns();

/* A user geometry with the callbacks of stand-ins. NULL where Embree makes none. */
RTCGeometry newUserGeometry(RTCDevice device, StandIn* standIn);

} // namespace interposer
