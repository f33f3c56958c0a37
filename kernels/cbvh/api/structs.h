// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Structs of include/embree3 that may grow (operations/struct_size.h), and conversions of internal structs to public
 * ones. vulkan/host/structs.h lists the structs of rtcore_vulkan.h. */

#include "../operations/struct_size.h"
#include "../embree/scene.h"
#include "../../../include/embree3/rtcore_compression.h"
#include "../base/surface_statistics.h"

namespace embree {
namespace core {
/* Each with the last member of the struct's first version: never change it when appending members. */
CBVH_EXTENSIBLE_STRUCT(RTCCompressionArguments, progressUserPtr);
CBVH_EXTENSIBLE_STRUCT(RTCCompressionStatistics, cacheBytesPerThread);
} // namespace core

/*! Throws RTC_ERROR_INVALID_ARGUMENT if a pointer argument is null. name: of the argument. */
inline void requireNotNull(const void* argument, const char* name) {
  if (!argument) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, std::string(name) + " is NULL");
}

inline RTCCompressionStatistics toPublic(const cbvh::CompressionStatistics& statistics) {
  RTCCompressionStatistics result = RTCCompressionStatistics();
  cbvh::forEachMember(
      result, statistics, [](size_t& to, size_t value) { to = value; }, [](float& to, float value) { to = value; });
  if (statistics.numInvalidQuads) {
    result.firstInvalidGeomID = statistics.firstInvalidGeometry;
    result.firstInvalidPrimID = statistics.firstInvalidPrimitive;
  }
  return result;
}
} // namespace embree
