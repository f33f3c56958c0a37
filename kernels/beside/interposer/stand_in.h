// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* In scenes, a user geometry of Embree (the substitute) replaces an application's geometry. A StandIn is the user data
 * of the substitute: what its callbacks need. */

#include "real.h"

#include <atomic>
#include <cbvh/cbvh.h>
#include <cstddef>
#include <cstdint>

namespace interposer {

struct StandIn
{
  CbvhGroup group;               // NULL until built
  RTCGeometry original;          // the application's geometry
  void* userData;                // user data of the original
  RTCFilterFunctionN intersectFilter, occludedFilter;
  bool takesArgumentFilters;     // see rtcSetGeometryEnableFilterFunctionFromArguments
};

/* All stand-ins are in one address range, so that two comparisons distinguish them from an application's user data. A
 * thread may call asStandIn while another creates the first stand-in: readers read the size first, which is 0 until
 * begin is stored. */
struct StandInRange
{
  std::atomic<uintptr_t> begin, size;
};
extern StandInRange standInRange;

/* Returns the StandIn if the user data is one, otherwise NULL. */
inline StandIn* asStandIn(void* userData)
{
  const uintptr_t size = standInRange.size.load(std::memory_order_acquire);
  return uintptr_t(userData) - standInRange.begin.load(std::memory_order_relaxed) < size ? (StandIn*)userData : nullptr;
}

/* Returns a zeroed StandIn, or NULL if the address range is exhausted. */
StandIn* newStandIn();
void deleteStandIn(StandIn* standIn);

/* False until the first stand-in is created. Until then, queries are passed to Embree unchanged. */
bool hasStandIns();

/* Creates a substitute, with the callbacks of queries.cpp. Returns NULL if Embree fails. */
RTCGeometry newUserGeometry(RTCDevice device, StandIn* standIn);

} // namespace interposer
