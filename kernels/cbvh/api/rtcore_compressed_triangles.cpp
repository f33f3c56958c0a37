// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The C API of include/embree3/rtcore_compressed_triangles.h: checks pointers, calls operations/stored_surface.h, and
 * reports its exceptions to the device. */

#define RTC_EXPORT_API

#include "structs.h"
#include "../operations/stored_surface.h"

using namespace embree;

RTC_NAMESPACE_BEGIN;

RTC_API bool rtcFindCompressedTriangle(RTCGeometry hgeometry, float time, unsigned int primID, float u, float v,
                                       const float* Ng, struct RTCCompressedTriangle* triangle) {
  Geometry* geometry = (Geometry*)hgeometry;
  RTC_CATCH_BEGIN;
  requireNotNull(geometry, "geometry");
  requireNotNull(triangle, "triangle");
  cbvh::StoredTriangle found;
  if (!core::findTriangle(geometry, time, primID, u, v, Ng, found)) return false;
  static_assert(sizeof(*triangle) == sizeof(found), "RTCCompressedTriangle never grows");
  memcpy(triangle, &found, sizeof(found));
  return true;
  RTC_CATCH_END2(geometry);
  return false;
}

RTC_API void rtcForEachCompressedPart(RTCGeometry hgeometry, float time, RTCCompressedPartFunction function,
                                      void* userPtr) {
  Geometry* geometry = (Geometry*)hgeometry;
  const Ref<Geometry> held(geometry); // for RTC_CATCH_END2: the function may release the geometry
  RTC_CATCH_BEGIN;
  requireNotNull(geometry, "geometry");
  requireNotNull((const void*)function, "function");
  core::forEachPart(geometry, time, [&](const cbvh::StoredPart& part) {
    const RTCCompressedPart publicPart = toPublic(part);
    return function(userPtr, &publicPart);
  });
  RTC_CATCH_END2(geometry);
}

RTC_NAMESPACE_END
