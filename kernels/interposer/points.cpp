// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Overrides Embree's point queries. These call a function for each primitive near the point, except for subdivision
 * surfaces. For a substitute, the function is called for each primitive with a stored triangle near the point; a
 * primitive with several may have several calls, as with Embree's grids. */

#include "objects.h"

#include <cmath>

namespace interposer { namespace {

struct PointQuery {
  RTCScene scene;
  RTCPointQueryFunction function; // NULL if only those of geometries are called
  unsigned int firstLevel;        // number of instances that the application entered before the query
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

/* A call of Embree for a substitute, and the calls of the application's functions for its primitives. */
class SubstituteCalls {
public:
  SubstituteCalls(const SubstituteData& data, const RTCPointQueryFunctionArguments& args)
    : data(data),
      args(args),
      callRadius(args.query->radius) {}

  /* Returns true if a function changed the query. */
  bool run() {
    const RTCPointQueryContext& context = *args.context;
    CbvhPointQuery query = CbvhPointQuery();
    float p[3] = {args.query->x, args.query->y, args.query->z};
    if (context.instStackSize > 0) enterInstance(context.world2inst[context.instStackSize - 1], p);
    query.x = p[0];
    query.y = p[1];
    query.z = p[2];
    query.time = args.query->time;
    query.radius = localRadius();
    query.userPtr = this;
    query.function = [](CbvhPointFunctionArguments* args) {
      ((SubstituteCalls*)args->userPtr)->call(args);
      return 0;
    };
    cbvhPointQuery(data.group, &query, nullptr);
    return isChanged;
  }

private:
  /* Sets p to the point in the instance, and `scale` to a bound of the factor of distances: the square root of the sum
   * of squares is at least the largest singular value. matrix: columns of 4 floats. */
  void enterInstance(const float* matrix, float p[3]) {
    const float world[3] = {p[0], p[1], p[2]};
    double squares = 0;
    for (int row = 0; row < 3; row++) {
      double sum = matrix[12 + row];
      for (int column = 0; column < 3; column++) {
        sum += double(matrix[4 * column + row]) * world[column];
        squares += double(matrix[4 * column + row]) * matrix[4 * column + row];
      }
      p[row] = float(sum);
    }
    scale = args.similarityScale > 0 ? args.similarityScale : float(std::sqrt(squares));
  }

  /* Distances between the stored and the application's triangles are at most data.deviation. */
  float localRadius() const { return args.query->radius * scale * 1.00001f + data.deviation; }

  void call(CbvhPointFunctionArguments* found) {
    const unsigned int primID = found->point->primID;
    if (hasCalled && primID == args.primID && args.query->radius == callRadius) return;
    hasCalled = true;
    args.primID = primID;
    callRadius = args.query->radius;
    if (current->function) isChanged |= current->function(&args);
    if (data.pointQuery) isChanged |= data.pointQuery(&args);
    found->radius = std::fmin(found->radius, localRadius());
  }

  const SubstituteData& data;
  RTCPointQueryFunctionArguments args; // of the application's functions
  float scale = 1;                     // factor of distances in the instance
  bool hasCalled = false, isChanged = false;
  float callRadius; // of the query, before the last call
};

bool callFunctions(RTCPointQueryFunctionArguments* args) {
  const SubstituteData* const data =
      Objects::get().findSubstitute(current->scene, *args->context, current->firstLevel, args->geomID);
  if (!data) return current->function && current->function(args);
  const bool isCalled = data->group && data->hasPointQueries && (current->function || data->pointQuery);
  return isCalled && SubstituteCalls(*data, *args).run();
}

/* query: calls Embree's function with the RTCPointQueryFunction that it receives. */
template<typename Query>
bool runQuery(RTCScene scene, const RTCPointQueryContext* context, RTCPointQueryFunction function, const Query& query) {
  if (!hasSubstitutes() || !isActive()) return query(function);
  const PointQuery entered = {scene, function, context->instStackSize};
  const QueryScope scope(&entered);
  return query(callFunctions);
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
