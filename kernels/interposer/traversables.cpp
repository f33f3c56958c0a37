// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Overrides Embree 4.4's queries of traversables. On CPUs, a traversable is the handle of its scene, so each override
 * calls the override for scenes. It does not call Embree's function for traversables, which calls Embree's function
 * for scenes: through the dynamic linker, which then finds our override a second time, or directly, so that no override
 * runs. Which of the two happens depends on the compiler of Embree.
 *
 * Embree 4.3 has no traversables. The definitions below depend only on types of Embree 4.3, so that one library works
 * with all versions. */

#include "real.h"

typedef struct RTCTraversableTy* RTCTraversable;

static RTCScene sceneOf(RTCTraversable traversable) { return (RTCScene)traversable; }

RTC_API void* rtcGetGeometryUserDataFromTraversable(RTCTraversable traversable, unsigned int geomID) {
  return rtcGetGeometryUserDataFromScene(sceneOf(traversable), geomID);
}

RTC_API void rtcTraversableIntersect1(RTCTraversable traversable, RTCRayHit* rayhit, RTCIntersectArguments* args) {
  rtcIntersect1(sceneOf(traversable), rayhit, args);
}
RTC_API void rtcTraversableOccluded1(RTCTraversable traversable, RTCRay* ray, RTCOccludedArguments* args) {
  rtcOccluded1(sceneOf(traversable), ray, args);
}
RTC_API bool rtcTraversablePointQuery(RTCTraversable traversable, RTCPointQuery* query, RTCPointQueryContext* context,
                                      RTCPointQueryFunction queryFunc, void* userPtr) {
  return rtcPointQuery(sceneOf(traversable), query, context, queryFunc, userPtr);
}

#define PACKET_QUERIES(N) \
  RTC_API void rtcTraversableIntersect##N(const int* valid, RTCTraversable traversable, RTCRayHit##N* rayhit, \
                                          RTCIntersectArguments* args) { \
    rtcIntersect##N(valid, sceneOf(traversable), rayhit, args); \
  } \
  RTC_API void rtcTraversableOccluded##N(const int* valid, RTCTraversable traversable, RTCRay##N* ray, \
                                         RTCOccludedArguments* args) { \
    rtcOccluded##N(valid, sceneOf(traversable), ray, args); \
  } \
  RTC_API bool rtcTraversablePointQuery##N(const int* valid, RTCTraversable traversable, RTCPointQuery##N* query, \
                                           RTCPointQueryContext* context, RTCPointQueryFunction queryFunc, \
                                           void** userPtr) { \
    return rtcPointQuery##N(valid, sceneOf(traversable), query, context, queryFunc, userPtr); \
  }
PACKET_QUERIES(4)
PACKET_QUERIES(8)
PACKET_QUERIES(16)
