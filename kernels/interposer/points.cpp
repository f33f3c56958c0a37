// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Overrides Embree's point queries. These call a function for each primitive near the point, except for subdivision
 * surfaces. Calls for substitutes are not passed on, because the application does not know these primitives. */

#include "objects.h"
#include "options.h"

namespace interposer { namespace {

struct PointQuery {
  RTCScene scene;
  RTCPointQueryFunction function;
  unsigned int firstLevel; // number of instances that the application entered before the query
};
thread_local const PointQuery* current = nullptr; // innermost query of the thread

/* Sets `current` while it exists. A query's function may start another query. */
struct QueryScope {
  explicit QueryScope(const PointQuery* query) : outer(current) { current = query; }
  ~QueryScope() { current = outer; }
  QueryScope(const QueryScope&) = delete;
  QueryScope& operator=(const QueryScope&) = delete;

private:
  const PointQuery* const outer;
};

bool callUnlessSubstituted(RTCPointQueryFunctionArguments* args) {
  if (!Objects::get().isSubstituted(current->scene, *args->context, current->firstLevel, args->geomID))
    return current->function(args);
  return false;
}

/* query: calls Embree's function with the RTCPointQueryFunction that it receives. */
template<typename Query>
bool runQuery(RTCScene scene, const RTCPointQueryContext* context, RTCPointQueryFunction function, const Query& query) {
  if (!hasSubstitutes() || !isActive()) return query(function);
  if (options().compressesGrids || options().compressesQuads || options().compressesTriangles)
    warnOnce("point queries do not find grids, quads and triangles that are compressed");
  if (!function) return query(nullptr); // Embree calls those of geometries; substitutes have none
  const PointQuery entered = {scene, function, context->instStackSize};
  const QueryScope scope(&entered);
  return query(callUnlessSubstituted);
}

}} // namespace interposer

using namespace interposer;

RTC_API bool rtcPointQuery(RTCScene scene, RTCPointQuery* query, RTCPointQueryContext* context,
                           RTCPointQueryFunction queryFunc, void* userPtr) {
  return runQuery(scene, context, queryFunc, [&](RTCPointQueryFunction function) {
    return REAL(rtcPointQuery)(scene, query, context, function, userPtr);
  });
}

#define PACKET_POINT_QUERY(N) \
  RTC_API bool rtcPointQuery##N(const int* valid, RTCScene scene, RTCPointQuery##N* query, \
                                RTCPointQueryContext* context, RTCPointQueryFunction queryFunc, void** userPtr) { \
    return runQuery(scene, context, queryFunc, [&](RTCPointQueryFunction function) { \
      return REAL(rtcPointQuery##N)(valid, scene, query, context, function, userPtr); \
    }); \
  }
PACKET_POINT_QUERY(4)
PACKET_POINT_QUERY(8)
PACKET_POINT_QUERY(16)
