// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* In scenes, a user geometry of Embree substitutes the geometry of the application. A StandIn is the user data of this
 * user geometry. */

#include "real.h"

#include <atomic>
#include <cbvh/cbvh.h>
#include <cstddef>
#include <cstdint>

namespace interposer {

struct StandIn
{
  CbvhGroup group;               // NULL until it is built
  RTCGeometry original;          // geometry of the application
  void* userData;                // user data of the original
  RTCFilterFunctionN intersectFilter, occludedFilter;
  bool takesArgumentFilters;     // see rtcSetGeometryEnableFilterFunctionFromArguments
};

/* All stand-ins are in one range of addresses, so that two comparisons distinguish them from an application's user
 * data. One thread may call asStandIn while another creates the first stand-in: readers read the size first, and it is
 * 0 until begin is stored. */
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

/* Returns NULL if the range of addresses is exhausted. */
StandIn* newStandIn();
void deleteStandIn(StandIn* standIn);

/* Returns false until the first stand-in is created. Until then, queries are passed to Embree unchanged. */
bool hasStandIns();

/* Creates a user geometry with the callbacks of stand-ins. Returns NULL if Embree fails. */
RTCGeometry newUserGeometry(RTCDevice device, StandIn* standIn);

} // namespace interposer
