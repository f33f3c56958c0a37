// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "closest_point.h"
#include "../base/closest_point_query.h"

namespace embree {
bool cbvh::ClosestPointQuery::mark(RTCPointQueryFunctionArguments* args) {
  ((ClosestPointQuery*)args->userPtr)->hasOthers = true;
  return false;
}

void core::requireCommitted(const Scene* scene) {
  if (scene->isModified()) throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the scene is not committed");
}

bool core::findClosestPoint(Scene* scene, const float p[3], float time, float radius, cbvh::PointFunction function,
                            void* userPtr, cbvh::PointOnSurface& closest) {
  PointQuery query(Vec3fa(p[0], p[1], p[2]), radius, time);
  RTCPointQueryContext user;
  rtcInitPointQueryContext(&user);
  cbvh::ClosestPointQuery context(scene, &query, &user, function, userPtr);
  scene->intersectors.pointQuery(&query, &context);
  if (context.isFound) closest = context.closest;
  if (context.hasOthers)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                   "a geometry near the point is not compressed as cTILE or cVERT, or is in an instance: use "
                   "rtcPointQuery");
  return context.isFound;
}
} // namespace embree
