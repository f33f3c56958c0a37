// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* In scenes, a user geometry of Embree (the substitute) replaces an application's geometry. SubstituteData is the user
 * data of the substitute, for its callbacks. */

#include "real.h"

#include <atomic>
#include <cbvh/cbvh.h>
#include <cstddef>
#include <cstdint>

namespace interposer {

struct SubstituteData {
  CbvhGroup group;      // NULL if not built: at first, during builds, after failures
  RTCGeometry original; // the application's geometry
  void* userData;       // user data of the original
  RTCFilterFunctionN intersectFilter, occludedFilter;
  bool usesArgumentFilter; // see rtcSetGeometryEnableFilterFunctionFromArguments
  RTCPointQueryFunction pointQuery;
  bool hasPointQueries; // Embree calls functions of point queries for geometries of this type
  float deviation;      // largest distance by which a vertex was moved
};

/* One address range contains all SubstituteData, so that a comparison distinguishes them from an application's user
 * data. A thread may call asSubstituteData while another creates the first one: readers read the size first, which is 0
 * until begin is stored. */
struct SubstituteDataRange {
  std::atomic<uintptr_t> begin, size;
};
extern SubstituteDataRange substituteDataRange;

/* Returns NULL for user data of the application. */
inline SubstituteData* asSubstituteData(void* userData) {
  const uintptr_t size = substituteDataRange.size.load(std::memory_order_acquire);
  const uintptr_t offset = uintptr_t(userData) - substituteDataRange.begin.load(std::memory_order_relaxed);
  return offset < size ? (SubstituteData*)userData : nullptr;
}

/* Returns zeroed data, or NULL if the address range is exhausted or cannot be reserved. */
SubstituteData* newSubstituteData();
/* data: result of newSubstituteData(), not NULL. */
void deleteSubstituteData(SubstituteData* data);

/* False until the first substitute is created. Until then, queries are passed to Embree unchanged. */
bool hasSubstitutes();

/* Creates a substitute, with the callbacks of queries.cpp. Returns NULL if Embree fails. */
RTCGeometry newUserGeometry(RTCDevice device, SubstituteData* data);

} // namespace interposer
