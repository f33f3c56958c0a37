// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Finds the closest points of groups. */

#include "group.h"
#include "points.h"
#include "structs.h"

#include "cbvh/operations/closest_point.h"

namespace {

/* Calls the function of a query. */
bool callFunction(void* queryPtr, const embree::cbvh::PointOnSurface& found, float& radius) {
  const CbvhPointQuery& query = *(const CbvhPointQuery*)queryPtr;
  const CbvhClosestPoint point = embree::capi::toPublic(found);
  CbvhPointFunctionArguments args = {query.userPtr, &point, radius};
  const int isAccepted = query.function(&args);
  radius = args.radius;
  return isAccepted != 0;
}

} // namespace

namespace embree::capi {

bool queryPoint(RTCScene scene, const CbvhPointQuery* query, CbvhClosestPoint* closest) {
  CbvhPointQuery read = core::readStruct(query);
  const float p[3] = {read.x, read.y, read.z};
  checkPoint(p, read.radius);
  cbvh::PointOnSurface found;
  const bool isFound = core::findClosestPoint((Scene*)scene, p, read.time, read.radius,
                                              read.function ? callFunction : nullptr, &read, found);
  if (isFound && closest) *closest = toPublic(found);
  return isFound;
}

} // namespace embree::capi

int cbvhPointQuery(CbvhGroup group, const CbvhPointQuery* query, CbvhClosestPoint* closest) {
  if (!group || !query) {
    embree::capi::rejectArgument("group or query is NULL");
    return 0;
  }
  bool isFound = false;
  embree::capi::guarded(group->context.get(), [&] {
    if (!group->wasCommitted)
      throw embree::capi::Failure{CBVH_ERROR_INVALID_OPERATION,
                                  "the group is not committed: call cbvhCommitGroup first"};
    isFound = embree::capi::queryPoint(group->scene, query, closest);
  });
  return isFound;
}
