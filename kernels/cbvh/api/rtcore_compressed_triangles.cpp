// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define RTC_EXPORT_API

#include "stored_blocks.h"

using namespace embree;

namespace
{
  /*! of a geometry's first time step */
  float firstTime (RTCGeometry geometry) { return geometry ? ((Geometry*)geometry)->time_range.lower : 0.0f; }
}

RTC_NAMESPACE_BEGIN;

RTC_API bool rtcGetCompressedTriangleAtTime (RTCGeometry hgeometry, float time, unsigned int primID, float u, float v, const float* Ng, struct RTCCompressedTriangle* triangle)
{
  Geometry* geometry = (Geometry*) hgeometry;
  RTC_CATCH_BEGIN;
  const SurfaceBlocks& blocks = storedBlocksOf(hgeometry);
  if (triangle == nullptr)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"triangle is NULL");
  return blocks.index().find(traversalTime(geometry,time),primID,u,v,Ng,*triangle);
  RTC_CATCH_END2(geometry);
  return false;
}

RTC_API void rtcForEachCompressedPartAtTime (RTCGeometry hgeometry, float time, RTCCompressedPartFunction function, void* userPtr)
{
  Geometry* geometry = (Geometry*) hgeometry;
  RTC_CATCH_BEGIN;
  const SurfaceBlocks& blocks = storedBlocksOf(hgeometry);
  if (function == nullptr)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"function is NULL");
  cbvh::forEachPart(blocks,traversalTime(geometry,time),[&](const cbvh::StoredBlock&, const RTCCompressedPart& part) { return function(userPtr,&part); });
  RTC_CATCH_END2(geometry);
}

RTC_API bool rtcGetCompressedTriangle (RTCGeometry geometry, unsigned int primID, float u, float v, const float* Ng, struct RTCCompressedTriangle* triangle) {
  return rtcGetCompressedTriangleAtTime(geometry,firstTime(geometry),primID,u,v,Ng,triangle);
}

RTC_API void rtcForEachCompressedPart (RTCGeometry geometry, RTCCompressedPartFunction function, void* userPtr) {
  rtcForEachCompressedPartAtTime(geometry,firstTime(geometry),function,userPtr);
}

RTC_NAMESPACE_END
