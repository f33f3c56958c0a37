// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Finds the closest points of groups. */

#include "group.h"
#include "structs.h"

#include "cbvh/operations/closest_point.h"

#include <cmath>
#include <cstdio>

namespace {

CbvhClosestPoint toPublic(const embree::cbvh::PointOnSurface& from) {
  return {from.p[0],  from.p[1],  from.p[2], from.distance, from.Ng[0],
          from.Ng[1], from.Ng[2], from.u,    from.v,        from.primID,
          from.geomID};
}

/* Calls the function of a query. */
bool callFunction(void* queryPtr, const embree::cbvh::PointOnSurface& found, float& radius) {
  const CbvhPointQuery& query = *(const CbvhPointQuery*)queryPtr;
  const CbvhClosestPoint point = toPublic(found);
  CbvhPointFunctionArguments args = {query.userPtr, &point, radius};
  const int isAccepted = query.function(&args);
  radius = args.radius;
  return isAccepted != 0;
}

void check(const CbvhPointQuery& query) {
  const float largest = 1e18f; // as Embree's largest coordinates of rays
  for (const float x : {query.x, query.y, query.z})
    if (!(std::fabs(x) <= largest)) {
      char text[96];
      std::snprintf(text, sizeof(text), "the query's point has the coordinate %g: expected -1e18 to 1e18", double(x));
      throw embree::capi::Failure{CBVH_ERROR_INVALID_ARGUMENT, text};
    }
  embree::capi::require(query.radius >= 0, "the query's radius is negative or NaN: expected at least 0");
}

} // namespace

int cbvhPointQuery(CbvhGroup group, const CbvhPointQuery* query, CbvhClosestPoint* closest) {
  if (!group || !query) {
    embree::capi::rejectArgument("group or query is NULL");
    return 0;
  }
  int isFound = 0;
  embree::capi::guarded(group->context.get(), [&] {
    CbvhPointQuery read = embree::core::readStruct(query);
    check(read);
    if (!group->wasCommitted)
      throw embree::capi::Failure{CBVH_ERROR_INVALID_OPERATION,
                                  "the group is not committed: call cbvhCommitGroup first"};
    const float p[3] = {read.x, read.y, read.z};
    embree::cbvh::PointOnSurface found;
    isFound = embree::core::findClosestPoint((embree::Scene*)group->scene, p, read.time, read.radius,
                                             read.function ? callFunction : nullptr, &read, found);
    if (isFound && closest) *closest = toPublic(found);
  });
  return isFound;
}
