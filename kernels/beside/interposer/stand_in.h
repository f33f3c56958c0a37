// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The user data of the user geometry that substitutes a geometry in scenes. */

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

/* Returns NULL if there is no room. */
StandIn* newStandIn();
void deleteStandIn(StandIn* standIn);

/* False if there has never been one: queries are then passed to Embree unchanged. */
bool hasStandIns();

/* Creates a user geometry with the callbacks of stand-ins. Returns NULL if Embree fails. */
RTCGeometry newUserGeometry(RTCDevice device, StandIn* standIn);

} // namespace interposer
