// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The callbacks by which Embree traces substitutes, and overrides of Embree's functions that trace rays. The overrides
 * store the RTCIntersectArguments or RTCOccludedArguments of the query for the callbacks. If the arguments contain a
 * function for user geometry, Embree 4 calls it instead of the geometry's own callback. Embree 4 does not pass the
 * arguments' filter to callbacks. */

#include "substitute_data.h"

#include <cbvh/cbvh.h>

namespace interposer {

namespace {

/* --- the current query of a thread --------------------------------------------------------- */

template<typename Arguments> struct Current {
  static thread_local const Arguments* arguments;
};
template<typename Arguments> thread_local const Arguments* Current<Arguments>::arguments = nullptr;

/* Sets the current arguments while it exists. Restores the outer query's, because a filter may trace rays. */
template<typename Arguments>
struct QueryScope {
  explicit QueryScope(const Arguments* arguments) : outer(Current<Arguments>::arguments) {
    Current<Arguments>::arguments = arguments;
  }
  ~QueryScope() { Current<Arguments>::arguments = outer; }
  QueryScope(const QueryScope&) = delete;
  QueryScope& operator=(const QueryScope&) = delete;

private:
  const Arguments* const outer;
};

/* Returns the filter of the query's arguments, or NULL if Embree would not call it for this geometry. */
template<typename Arguments>
RTCFilterFunctionN filterOfArguments(const SubstituteData& data) {
  const Arguments* const arguments = Current<Arguments>::arguments;
  if (!arguments || !arguments->filter) return nullptr;
  return data.usesArgumentFilter || (arguments->flags & RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER) ? arguments->filter
                                                                                                   : nullptr;
}

/* --- filters -------------------------------------------------------------------------------- */

/* Arguments of a callback, and the filters that Embree would call for its hits. */
struct FilteredCall {
  const SubstituteData* data;
  RTCRayQueryContext* context;
  RTCFilterFunctionN geometryFilter, argumentsFilter;
};

/* Calls the application's filters as Embree does: the geometry's, then the arguments'. */
void filter(void* userPtr, int* valid, void* ray, void* hit) {
  const FilteredCall& call = *(const FilteredCall*)userPtr;
  const RTCFilterFunctionNArguments args = {valid, call.data->userData, call.context, (RTCRayN*)ray, (RTCHitN*)hit, 1};
  if (call.geometryFilter) call.geometryFilter(&args);
  if (*valid && call.argumentsFilter) call.argumentsFilter(&args);
}

/* Traces the group of a substitute. trace: cbvhIntersectGeometry or cbvhOccludedGeometry. */
template<typename Trace, typename Arguments>
void traceGroup(const Trace& trace, const Arguments* args, void* rays, const SubstituteData& data,
                RTCFilterFunctionN geometryFilter, RTCFilterFunctionN argumentsFilter) {
  if (!data.group) return;
  FilteredCall call = {&data, args->context, geometryFilter, argumentsFilter};
  CbvhGeometryQuery query = CbvhGeometryQuery();
  query.group = data.group;
  query.valid = args->valid;
  query.rays = rays;
  query.N = args->N;
  query.geomID = args->geomID;
  query.numLevels = RTC_MAX_INSTANCE_LEVEL_COUNT;
  query.instIDs = args->context->instID;
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  query.instPrimIDs = args->context->instPrimID;
#endif
  query.filter = geometryFilter || argumentsFilter ? filter : nullptr;
  query.filterUserPtr = &call;
  trace(&query);
}

/* --- callbacks -------------------------------------------------------------------------------- */

void computeBounds(const RTCBoundsFunctionArguments* args) {
  RTCBounds& bounds = *args->bounds_o;
  bounds = {1, 1, 1, 0, -1, -1, -1, 0}; // empty
  const CbvhGroup group = ((const SubstituteData*)args->geometryUserPtr)->group;
  if (group) cbvhGetGroupBounds(group, &bounds.lower_x, &bounds.upper_x);
}

void intersect(const RTCIntersectFunctionNArguments* args) {
  const SubstituteData& data = *(const SubstituteData*)args->geometryUserPtr;
  traceGroup(cbvhIntersectGeometry, args, args->rayhit, data, data.intersectFilter,
             filterOfArguments<RTCIntersectArguments>(data));
}

void occluded(const RTCOccludedFunctionNArguments* args) {
  const SubstituteData& data = *(const SubstituteData*)args->geometryUserPtr;
  traceGroup(cbvhOccludedGeometry, args, args->ray, data, data.occludedFilter,
             filterOfArguments<RTCOccludedArguments>(data));
}

/* Replace the application's functions for user geometry in a query's arguments, and call them except for
 * substitutes. */
void intersectUserGeometry(const RTCIntersectFunctionNArguments* args) {
  if (asSubstituteData(args->geometryUserPtr)) intersect(args);
  else Current<RTCIntersectArguments>::arguments->intersect(args);
}

void occludedUserGeometry(const RTCOccludedFunctionNArguments* args) {
  if (asSubstituteData(args->geometryUserPtr)) occluded(args);
  else Current<RTCOccludedArguments>::arguments->occluded(args);
}

/* Calls query(args). A function for user geometry in args is replaced by one that also handles substitutes.
 * query: calls Embree's function. */
template<typename Query>
void runQuery(RTCIntersectArguments* args, const Query& query) {
  if (!hasSubstitutes() || !isActive()) {
    query(args);
    return;
  }
  const QueryScope<RTCIntersectArguments> entered(args);
  if (!args || !args->intersect) {
    query(args);
    return;
  }
  RTCIntersectArguments changed = *args;
  changed.intersect = intersectUserGeometry;
  query(&changed);
}

template<typename Query>
void runQuery(RTCOccludedArguments* args, const Query& query) {
  if (!hasSubstitutes() || !isActive()) {
    query(args);
    return;
  }
  const QueryScope<RTCOccludedArguments> entered(args);
  if (!args || !args->occluded) {
    query(args);
    return;
  }
  RTCOccludedArguments changed = *args;
  changed.occluded = occludedUserGeometry;
  query(&changed);
}

} // namespace

RTCGeometry newUserGeometry(RTCDevice device, SubstituteData* data) {
  const RTCGeometry geometry = REAL(rtcNewGeometry)(device, RTC_GEOMETRY_TYPE_USER);
  if (!geometry) return nullptr;
  REAL(rtcSetGeometryUserPrimitiveCount)(geometry, 1);
  REAL(rtcSetGeometryUserData)(geometry, data);
  REAL(rtcSetGeometryBoundsFunction)(geometry, computeBounds, nullptr);
  REAL(rtcSetGeometryIntersectFunction)(geometry, intersect);
  REAL(rtcSetGeometryOccludedFunction)(geometry, occluded);
  return geometry;
}

} // namespace interposer

using namespace interposer;

RTC_API void rtcIntersect1(RTCScene scene, RTCRayHit* rayhit, RTCIntersectArguments* args) {
  runQuery(args, [&](RTCIntersectArguments* args) { REAL(rtcIntersect1)(scene, rayhit, args); });
}
RTC_API void rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* args) {
  runQuery(args, [&](RTCOccludedArguments* args) { REAL(rtcOccluded1)(scene, ray, args); });
}

#define PACKET_QUERIES(N) \
  RTC_API void rtcIntersect##N(const int* valid, RTCScene scene, RTCRayHit##N* rayhit, RTCIntersectArguments* args) { \
    runQuery(args, [&](RTCIntersectArguments* args) { REAL(rtcIntersect##N)(valid, scene, rayhit, args); }); \
  } \
  RTC_API void rtcOccluded##N(const int* valid, RTCScene scene, RTCRay##N* ray, RTCOccludedArguments* args) { \
    runQuery(args, [&](RTCOccludedArguments* args) { REAL(rtcOccluded##N)(valid, scene, ray, args); }); \
  }
PACKET_QUERIES(4)
PACKET_QUERIES(8)
PACKET_QUERIES(16)
