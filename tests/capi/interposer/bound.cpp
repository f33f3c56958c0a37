// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Makes libembree4 behave as if another compiler had built it. Preloaded after the interposer, this library contains
 * functions for traversables that call libembree4's functions for scenes directly. In a libembree4 of GCC, the dynamic
 * linker sends these calls to the interposer.
 *
 * With BOUND_USER_DATA, only the function that Clang inlines is replaced. With BOUND_QUERIES, all functions are, as in
 * a libembree4 that was linked with -Bsymbolic. */

#include <cstdlib>
#include <dlfcn.h>
#include <embree4/rtcore.h>

namespace {

/* Returns a function of libembree4, even if a preloaded library overrides it. */
template<typename Function>
Function* ofEmbree(Function*, const char* name) {
  void* const embree = dlopen("libembree4.so.4", RTLD_LAZY | RTLD_NOLOAD);
  void* const function = embree ? dlsym(embree, name) : nullptr;
  if (!function) std::abort();
  return (Function*)function;
}

RTCScene sceneOf(RTCTraversable traversable) { return (RTCScene)traversable; }

} // namespace

#define EMBREE(name) \
  ([] { \
    static const auto function = ofEmbree(name, #name); \
    return function; \
  }())

extern "C" {

#if defined(BOUND_USER_DATA) || defined(BOUND_QUERIES)
void* rtcGetGeometryUserDataFromTraversable(RTCTraversable traversable, unsigned geomID) {
  return EMBREE(rtcGetGeometryUserDataFromScene)(sceneOf(traversable), geomID);
}
#endif

#if defined(BOUND_QUERIES)
void rtcTraversableIntersect1(RTCTraversable traversable, RTCRayHit* ray, RTCIntersectArguments* args) {
  EMBREE(rtcIntersect1)(sceneOf(traversable), ray, args);
}
void rtcTraversableOccluded1(RTCTraversable traversable, RTCRay* ray, RTCOccludedArguments* args) {
  EMBREE(rtcOccluded1)(sceneOf(traversable), ray, args);
}
void rtcTraversableForwardIntersect1(const RTCIntersectFunctionNArguments* args, RTCTraversable traversable,
                                     RTCRay* ray, unsigned instID) {
  EMBREE(rtcForwardIntersect1)(args, sceneOf(traversable), ray, instID);
}
void rtcTraversableForwardOccluded1(const RTCOccludedFunctionNArguments* args, RTCTraversable traversable, RTCRay* ray,
                                    unsigned instID) {
  EMBREE(rtcForwardOccluded1)(args, sceneOf(traversable), ray, instID);
}
bool rtcTraversablePointQuery(RTCTraversable traversable, RTCPointQuery* query, RTCPointQueryContext* context,
                              RTCPointQueryFunction function, void* userPtr) {
  return EMBREE(rtcPointQuery)(sceneOf(traversable), query, context, function, userPtr);
}

#define PACKET_QUERIES(N) \
  void rtcTraversableIntersect##N(const int* valid, RTCTraversable traversable, RTCRayHit##N* rays, \
                                  RTCIntersectArguments* args) { \
    EMBREE(rtcIntersect##N)(valid, sceneOf(traversable), rays, args); \
  } \
  void rtcTraversableOccluded##N(const int* valid, RTCTraversable traversable, RTCRay##N* rays, \
                                 RTCOccludedArguments* args) { \
    EMBREE(rtcOccluded##N)(valid, sceneOf(traversable), rays, args); \
  } \
  void rtcTraversableForwardIntersect##N(const int* valid, const RTCIntersectFunctionNArguments* args, \
                                         RTCTraversable traversable, RTCRay##N* rays, unsigned instID) { \
    EMBREE(rtcForwardIntersect##N)(valid, args, sceneOf(traversable), rays, instID); \
  } \
  void rtcTraversableForwardOccluded##N(const int* valid, const RTCOccludedFunctionNArguments* args, \
                                        RTCTraversable traversable, RTCRay##N* rays, unsigned instID) { \
    EMBREE(rtcForwardOccluded##N)(valid, args, sceneOf(traversable), rays, instID); \
  } \
  bool rtcTraversablePointQuery##N(const int* valid, RTCTraversable traversable, RTCPointQuery##N* query, \
                                   RTCPointQueryContext* context, RTCPointQueryFunction function, void** userPtr) { \
    return EMBREE(rtcPointQuery##N)(valid, sceneOf(traversable), query, context, function, userPtr); \
  }
PACKET_QUERIES(4)
PACKET_QUERIES(8)
PACKET_QUERIES(16)
#endif

} // extern "C"
