// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Traces rays through groups. geomIDs are RTC_INVALID_GEOMETRY_ID while the kernels trace, so that any other value
 * afterwards means a hit. Then rays without a hit get their geomIDs back, and all rays their instIDs, which belong to
 * the application. */

#include "group.h"
#include "structs.h"

#include <cstring>

namespace {

static_assert(sizeof(CbvhRay) == sizeof(RTCRay) && sizeof(CbvhHit) == sizeof(RTCHit),
              "CbvhRay and CbvhHit must have the layout of RTCRay and RTCHit");

struct QueryContext {
  RTCIntersectContext rtcContext; // first: filter() casts its address
  const CbvhQuery* query;

  QueryContext(const CbvhQuery* query) : query(query) {
    rtcInitIntersectContext(&rtcContext);
    if (!query) return;
    if (query->flags & CBVH_QUERY_FLAG_COHERENT) rtcContext.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    if (query->filter) rtcContext.filter = filter;
  }

  static void filter(const RTCFilterFunctionNArguments* args) {
    const CbvhQuery& query = *((const QueryContext*)args->context)->query;
    const CbvhFilterArguments cbvhArgs = {args->valid, query.filterUserPtr, args->ray, args->hit, args->N};
    query.filter(&cbvhArgs);
  }
};

constexpr unsigned int knownFlags = CBVH_QUERY_FLAG_COHERENT;

/* True if the query is valid, and the application was compiled with this version of CbvhQuery. */
inline bool isCurrent(const CbvhQuery* query) {
  return !query || (query->structSize == sizeof(CbvhQuery) && !(query->flags & ~knownFlags));
}

/* Calls trace() with a query for which isCurrent() is false, converted to this version. Reports an invalid query and
 * returns 0. Not inlined, to keep the usual path short. */
template<typename Trace>
__attribute__((noinline)) auto withConvertedQuery(CbvhGroup group, const CbvhQuery* query, const Trace& trace)
    -> decltype(trace(query)) {
  CbvhQuery converted;
  const CbvhContext context = group->context.get();
  const CbvhError error = embree::capi::guarded(context, [&] {
    converted = embree::core::readStruct(query);
    embree::capi::checkFlags(converted.flags, knownFlags, "query");
  });
  if (error != CBVH_OK) return 0;
  return trace(&converted);
}

/* Reports that a group was never committed. Not inlined, to keep the usual path short. */
__attribute__((noinline)) void reportUncommitted(CbvhGroup group) {
  embree::capi::guarded(group->context.get(), [] {
    throw embree::capi::Failure{CBVH_ERROR_INVALID_OPERATION, "the group is not committed: call cbvhCommitGroup first"};
  });
}

/* True if rays can be traced. Otherwise reports an error. */
inline bool isTraceable(CbvhGroup group) {
  if (__builtin_expect(group->wasCommitted, true)) return true;
  reportUncommitted(group);
  return false;
}

template<unsigned int K> struct PacketKernels;
template<> struct PacketKernels<4> {
  typedef RTCRayHit4 RayHits;
  typedef RTCRay4 Rays;
  static constexpr auto intersect = rtcIntersect4;
  static constexpr auto occluded = rtcOccluded4;
};
template<> struct PacketKernels<8> {
  typedef RTCRayHit8 RayHits;
  typedef RTCRay8 Rays;
  static constexpr auto intersect = rtcIntersect8;
  static constexpr auto occluded = rtcOccluded8;
};
template<> struct PacketKernels<16> {
  typedef RTCRayHit16 RayHits;
  typedef RTCRay16 Rays;
  static constexpr auto intersect = rtcIntersect16;
  static constexpr auto occluded = rtcOccluded16;
};

template<unsigned int K>
struct AllValid {
  alignas(64) int valid[K];
  AllValid() {
    for (int& v : valid) v = -1;
  }
};

/* Returns a mask of the rays with a hit. valid: NULL if all rays are valid. */
template<unsigned int K>
unsigned int intersect(CbvhGroup group, const int* valid, void* rays, const CbvhQuery* query) {
  if (!group || !rays) {
    embree::capi::rejectArgument("group or rays are NULL");
    return 0;
  }
  if (!isCurrent(query))
    return withConvertedQuery(group, query,
                              [=](const CbvhQuery* converted) { return intersect<K>(group, valid, rays, converted); });
  if (!isTraceable(group)) return 0;
  typename PacketKernels<K>::RayHits& packet = *(typename PacketKernels<K>::RayHits*)rays;
  static const AllValid<K> all;
  if (!valid) valid = all.valid;
  unsigned int geomIDs[K], instIDs[K];
  std::memcpy(geomIDs, packet.hit.geomID, sizeof(geomIDs));
  std::memcpy(instIDs, packet.hit.instID[0], sizeof(instIDs));
  std::memset(packet.hit.geomID, 0xFF, sizeof(geomIDs));
  QueryContext context(query);
  PacketKernels<K>::intersect(valid, group->scene, &context.rtcContext, &packet);
  std::memcpy(packet.hit.instID[0], instIDs, sizeof(instIDs));
  unsigned int hits = 0;
  for (unsigned int i = 0; i < K; i++) {
    if (packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID) hits |= 1u << i;
    else packet.hit.geomID[i] = geomIDs[i];
  }
  return hits;
}

/* Returns a mask of the occluded rays, except rays whose tfar was negative before the call. */
template<unsigned int K>
unsigned int occluded(CbvhGroup group, const int* valid, void* rays, const CbvhQuery* query) {
  if (!group || !rays) {
    embree::capi::rejectArgument("group or rays are NULL");
    return 0;
  }
  if (!isCurrent(query))
    return withConvertedQuery(group, query,
                              [=](const CbvhQuery* converted) { return occluded<K>(group, valid, rays, converted); });
  if (!isTraceable(group)) return 0;
  typename PacketKernels<K>::Rays& packet = *(typename PacketKernels<K>::Rays*)rays;
  static const AllValid<K> all;
  if (!valid) valid = all.valid;
  unsigned int inactive = 0, hits = 0;
  for (unsigned int i = 0; i < K; i++)
    if (packet.tfar[i] < 0) inactive |= 1u << i;
  QueryContext context(query);
  PacketKernels<K>::occluded(valid, group->scene, &context.rtcContext, &packet);
  for (unsigned int i = 0; i < K; i++)
    if (packet.tfar[i] < 0) hits |= 1u << i;
  return hits & ~inactive;
}

} // namespace

int cbvhIntersect1(CbvhGroup group, CbvhRayHit* ray, const CbvhQuery* query) {
  if (!group || !ray) {
    embree::capi::rejectArgument("group or ray is NULL");
    return 0;
  }
  if (!isCurrent(query))
    return withConvertedQuery(group, query,
                              [=](const CbvhQuery* converted) { return cbvhIntersect1(group, ray, converted); });
  if (!isTraceable(group)) return 0;
  RTCRayHit* const rayHit = (RTCRayHit*)ray;
  const unsigned int geomID = rayHit->hit.geomID, instID = rayHit->hit.instID[0];
  rayHit->hit.geomID = RTC_INVALID_GEOMETRY_ID;
  QueryContext context(query);
  rtcIntersect1(group->scene, &context.rtcContext, rayHit);
  rayHit->hit.instID[0] = instID;
  if (rayHit->hit.geomID != RTC_INVALID_GEOMETRY_ID) return 1;
  rayHit->hit.geomID = geomID;
  return 0;
}

int cbvhOccluded1(CbvhGroup group, CbvhRay* ray, const CbvhQuery* query) {
  if (!group || !ray) {
    embree::capi::rejectArgument("group or ray is NULL");
    return 0;
  }
  if (!isCurrent(query))
    return withConvertedQuery(group, query,
                              [=](const CbvhQuery* converted) { return cbvhOccluded1(group, ray, converted); });
  if (!isTraceable(group) || ray->tfar < 0) return 0;
  QueryContext context(query);
  rtcOccluded1(group->scene, &context.rtcContext, (RTCRay*)ray);
  return ray->tfar < 0;
}

unsigned int cbvhIntersect4(CbvhGroup group, const int* valid, void* rays, const CbvhQuery* query) {
  return intersect<4>(group, valid, rays, query);
}
unsigned int cbvhIntersect8(CbvhGroup group, const int* valid, void* rays, const CbvhQuery* query) {
  return intersect<8>(group, valid, rays, query);
}
unsigned int cbvhIntersect16(CbvhGroup group, const int* valid, void* rays, const CbvhQuery* query) {
  return intersect<16>(group, valid, rays, query);
}
unsigned int cbvhOccluded4(CbvhGroup group, const int* valid, void* rays, const CbvhQuery* query) {
  return occluded<4>(group, valid, rays, query);
}
unsigned int cbvhOccluded8(CbvhGroup group, const int* valid, void* rays, const CbvhQuery* query) {
  return occluded<8>(group, valid, rays, query);
}
unsigned int cbvhOccluded16(CbvhGroup group, const int* valid, void* rays, const CbvhQuery* query) {
  return occluded<16>(group, valid, rays, query);
}
