// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's queries of a scene or, on request, of the traversable of the scene. Embree 4.3 has no traversables. */

#include <embree4/rtcore.h>

namespace scene_queries {

inline bool useTraversables = false;

#if RTC_VERSION >= 40400
constexpr bool haveTraversables = true;
/* Returns the result of one of two calls, in which `target` is the scene or its traversable. */
#define CALL(scene, ofScene, ofTraversable) \
  if (useTraversables) { \
    const RTCTraversable target = rtcGetSceneTraversable(scene); \
    return ofTraversable; \
  } \
  const RTCScene target = scene; \
  return ofScene
#else
constexpr bool haveTraversables = false;
#define CALL(scene, ofScene, ofTraversable) \
  const RTCScene target = scene; \
  return ofScene
#endif

inline void* getUserData(RTCScene scene, unsigned geomID) {
  CALL(scene, rtcGetGeometryUserDataFromScene(target, geomID), rtcGetGeometryUserDataFromTraversable(target, geomID));
}
inline void intersect(RTCScene scene, RTCRayHit* ray, RTCIntersectArguments* args) {
  CALL(scene, rtcIntersect1(target, ray, args), rtcTraversableIntersect1(target, ray, args));
}
inline void occluded(RTCScene scene, RTCRay* ray, RTCOccludedArguments* args) {
  CALL(scene, rtcOccluded1(target, ray, args), rtcTraversableOccluded1(target, ray, args));
}
inline void forward(const RTCIntersectFunctionNArguments* args, RTCScene scene, RTCRay* ray, unsigned instID) {
  CALL(scene, rtcForwardIntersect1(args, target, ray, instID),
       rtcTraversableForwardIntersect1(args, target, ray, instID));
}
inline void forward(const RTCOccludedFunctionNArguments* args, RTCScene scene, RTCRay* ray, unsigned instID) {
  CALL(scene, rtcForwardOccluded1(args, target, ray, instID),
       rtcTraversableForwardOccluded1(args, target, ray, instID));
}
inline bool pointQuery(RTCScene scene, RTCPointQuery* query, RTCPointQueryContext* context,
                       RTCPointQueryFunction function, void* userPtr) {
  CALL(scene, rtcPointQuery(target, query, context, function, userPtr),
       rtcTraversablePointQuery(target, query, context, function, userPtr));
}

#define PACKET_QUERIES(N) \
  inline void intersect(const int* valid, RTCScene scene, RTCRayHit##N* rays, RTCIntersectArguments* args) { \
    CALL(scene, rtcIntersect##N(valid, target, rays, args), rtcTraversableIntersect##N(valid, target, rays, args)); \
  } \
  inline void occluded(const int* valid, RTCScene scene, RTCRay##N* rays, RTCOccludedArguments* args) { \
    CALL(scene, rtcOccluded##N(valid, target, rays, args), rtcTraversableOccluded##N(valid, target, rays, args)); \
  } \
  inline void forward(const RTCIntersectFunctionNArguments* args, RTCScene scene, RTCRay##N* rays, unsigned instID) { \
    CALL(scene, rtcForwardIntersect##N(args->valid, args, target, rays, instID), \
         rtcTraversableForwardIntersect##N(args->valid, args, target, rays, instID)); \
  } \
  inline void forward(const RTCOccludedFunctionNArguments* args, RTCScene scene, RTCRay##N* rays, unsigned instID) { \
    CALL(scene, rtcForwardOccluded##N(args->valid, args, target, rays, instID), \
         rtcTraversableForwardOccluded##N(args->valid, args, target, rays, instID)); \
  } \
  inline bool pointQuery(const int* valid, RTCScene scene, RTCPointQuery##N* query, RTCPointQueryContext* context, \
                         RTCPointQueryFunction function, void** userPtr) { \
    CALL(scene, rtcPointQuery##N(valid, target, query, context, function, userPtr), \
         rtcTraversablePointQuery##N(valid, target, query, context, function, userPtr)); \
  }
PACKET_QUERIES(4)
PACKET_QUERIES(8)
PACKET_QUERIES(16)
#undef PACKET_QUERIES
#undef CALL

} // namespace scene_queries
