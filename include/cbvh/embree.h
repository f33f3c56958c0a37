// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#ifndef CBVH_EMBREE_H
#define CBVH_EMBREE_H

/* Compressed surfaces in the scenes of the Embree that a renderer has, 3.13 or 4: this header is compiled with the renderer, against that
 * Embree's own, which is to be included before.
 *
 *   #include <embree4/rtcore.h>
 *   #include <cbvh/embree.h>
 *
 *   RTCGeometry geometry = cbvhNewGeometry(device, group, 0);
 *   rtcAttachGeometry(scene, geometry);
 *
 * It is a geometry of type RTC_GEOMETRY_TYPE_USER with one primitive. A group has to be committed before, and to stay as long as the
 * geometry does; after another commit of it rtcCommitGeometry and rtcCommitScene take the new bounds.
 *
 * The primitives of a group's surfaces are numbered through, one surface behind the other: cbvhFindGroupPrimitive says which surface and which of its
 * primitives a hit's primID is. */

#include "cbvh.h"

#if !defined(RTC_VERSION_MAJOR)
#error "include Embree's rtcore.h before cbvh/embree.h"
#endif

#if defined(__cplusplus)
extern "C" {
#endif

enum CbvhGeometryFlags
{
  /* Filters that the application set for the geometry are called, of Embree 3 those of contexts too. */
  CBVH_GEOMETRY_FILTERS = 1,
#if RTC_VERSION_MAJOR >= 4
  /* The context of each query that may meet the geometry is a CbvhQueryContext, whose filter is called: Embree 4 does not hand user geometry those of
   * RTCIntersectArguments. */
  CBVH_GEOMETRY_CONTEXT_FILTERS = 2,
#endif
};

#if RTC_VERSION_MAJOR >= 4
struct CbvhQueryContext
{
  struct RTCRayQueryContext context;
  RTCFilterFunctionN filter;   /* or NULL */
};
typedef struct RTCRayQueryContext CbvhRTCContext;
#else
typedef struct RTCIntersectContext CbvhRTCContext;
#endif

/* --- words of RTCRayN and RTCHitN ------------------------------------------------------------ */

typedef unsigned int __attribute__((may_alias)) CbvhWord;

enum CbvhWords
{
  CBVH_RAY_DIR = 4, CBVH_RAY_TFAR = 8, CBVH_RAY_WORDS = 12,
  CBVH_HIT_PRIM_ID = 5, CBVH_HIT_GEOM_ID = 6, CBVH_HIT_INST_ID = 7   /* of all levels, and behind them those of primitives of instances */
};

static inline CbvhWord* cbvhWordOf(void* of, unsigned int N, unsigned int word, unsigned int i) { return (CbvhWord*)of + word*N + i; }

/* --- IDs of hits ------------------------------------------------------------------------ */

/* Writes what a hit has of the application's scene. hits: RTCHitN of N */
static inline void cbvhNameHit(void* hits, unsigned int N, unsigned int i, CbvhGroup group, unsigned int geomID, const CbvhRTCContext* context)
{
  const unsigned int surface = *cbvhWordOf(hits, N, CBVH_HIT_GEOM_ID, i);
  unsigned int level;
  if (surface != 0) *cbvhWordOf(hits, N, CBVH_HIT_PRIM_ID, i) += cbvhGetGroupFirstPrimitive(group, surface);
  *cbvhWordOf(hits, N, CBVH_HIT_GEOM_ID, i) = geomID;
  for (level = 0; level < RTC_MAX_INSTANCE_LEVEL_COUNT; level++) {
    *cbvhWordOf(hits, N, CBVH_HIT_INST_ID + level, i) = context->instID[level];
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
    *cbvhWordOf(hits, N, CBVH_HIT_INST_ID + RTC_MAX_INSTANCE_LEVEL_COUNT + level, i) = context->instPrimID[level];
#endif
  }
}

/* --- filters ----------------------------------------------------------------------------- */

struct CbvhFilterCall
{
  const void* args;    /* of the callback */
  CbvhGroup group;
  unsigned int geomID;
  CbvhRTCContext* context;
  unsigned int flags;
  int isOcclusion;
};

/* One hit at a time: the kernels' have IDs of their own, and the application's RTCHit may be longer. */
static inline void cbvhFilterHits(const struct CbvhFilterArguments* args)
{
  const struct CbvhFilterCall* const call = (const struct CbvhFilterCall*)args->userPtr;
  unsigned int i, word;
  for (i = 0; i < args->count; i++)
  {
    struct RTCFilterFunctionNArguments filter;
    struct RTCRay ray;
    struct RTCHit hit;
    int valid = -1;
    if (args->valid[i] == 0) continue;
    for (word = 0; word < CBVH_RAY_WORDS; word++) *cbvhWordOf(&ray, 1, word, 0) = *cbvhWordOf(args->rays, args->count, word, i);
    for (word = 0; word < CBVH_HIT_INST_ID; word++) *cbvhWordOf(&hit, 1, word, 0) = *cbvhWordOf(args->hits, args->count, word, i);
    cbvhNameHit(&hit, 1, 0, call->group, call->geomID, call->context);
    filter.valid = &valid;
    filter.geometryUserPtr = call->group;
    filter.context = call->context;
    filter.ray = (struct RTCRayN*)&ray;
    filter.hit = (struct RTCHitN*)&hit;
    filter.N = 1;
    if (call->flags & CBVH_GEOMETRY_FILTERS) {
#if RTC_VERSION_MAJOR >= 4
      if (call->isOcclusion) rtcInvokeOccludedFilterFromGeometry((const struct RTCOccludedFunctionNArguments*)call->args, &filter);
      else rtcInvokeIntersectFilterFromGeometry((const struct RTCIntersectFunctionNArguments*)call->args, &filter);
#else
      if (call->isOcclusion) rtcFilterOcclusion((const struct RTCOccludedFunctionNArguments*)call->args, &filter);
      else rtcFilterIntersection((const struct RTCIntersectFunctionNArguments*)call->args, &filter);
#endif
    }
#if RTC_VERSION_MAJOR >= 4
    if (valid && (call->flags & CBVH_GEOMETRY_CONTEXT_FILTERS)) {
      const struct CbvhQueryContext* const query = (const struct CbvhQueryContext*)call->context;
      if (query->filter) query->filter(&filter);
    }
#endif
    if (!valid) args->valid[i] = 0;
  }
}

/* --- callbacks of the geometry ------------------------------------------------------------ */

/* Packets go together where more than half of their rays count, and these go to the same sides. */
static inline unsigned int cbvhFlagsOfPacket(void* rays, unsigned int N, const int* valid)
{
  unsigned int axis, i, count = 0, negative[3] = {0, 0, 0};
  for (i = 0; i < N; i++) {
    if (valid[i] == 0) continue;
    count++;
    for (axis = 0; axis < 3; axis++) negative[axis] += *cbvhWordOf(rays, N, CBVH_RAY_DIR + axis, i) >> 31;
  }
  if (2*count <= N) return 0;
  for (axis = 0; axis < 3; axis++)
    if (negative[axis] != 0 && negative[axis] != count) return 0;
  return CBVH_QUERY_COHERENT;
}

static inline void cbvhStartQuery(struct CbvhQuery* query, struct CbvhFilterCall* call, const void* args, CbvhGroup group, unsigned int geomID, CbvhRTCContext* context,
                                  unsigned int flags, int isOcclusion)
{
  query->structSize = sizeof(*query);
  query->flags = 0;
  query->filter = flags ? cbvhFilterHits : NULL;
  query->filterPtr = call;
  if (flags) {
    call->args = args;
    call->group = group;
    call->geomID = geomID;
    call->context = context;
    call->flags = flags;
    call->isOcclusion = isOcclusion;
  }
#if RTC_VERSION_MAJOR < 4
  if (context->flags & RTC_INTERSECT_CONTEXT_FLAG_COHERENT) query->flags = CBVH_QUERY_COHERENT;
#endif
}

static inline void cbvhIntersectGeometry(const struct RTCIntersectFunctionNArguments* args, unsigned int flags)
{
  const CbvhGroup group = (CbvhGroup)args->geometryUserPtr;
  const unsigned int N = args->N;
  CbvhWord* const rays = (CbvhWord*)args->rayhit;
  CbvhWord* const hits = rays + CBVH_RAY_WORDS*N;
  struct CbvhQuery query;
  struct CbvhFilterCall call;
  unsigned int i, word, found = 0;
  cbvhStartQuery(&query, &call, args, group, args->geomID, args->context, flags, 0);
  if (N == 1) {
    if (args->valid[0] && cbvhIntersect1(group, (struct CbvhRayHit*)rays, &query)) cbvhNameHit(hits, 1, 0, group, args->geomID, args->context);
    return;
  }
  if (N == 4 || N == 8 || N == 16) {
    query.flags |= cbvhFlagsOfPacket(rays, N, args->valid);
    found = N == 4 ? cbvhIntersect4(group, args->valid, rays, &query) : N == 8 ? cbvhIntersect8(group, args->valid, rays, &query)
                                                                             : cbvhIntersect16(group, args->valid, rays, &query);
    for (i = 0; i < N; i++)
      if (found & (1u << i)) cbvhNameHit(hits, N, i, group, args->geomID, args->context);
    return;
  }
  for (i = 0; i < N; i++) {
    struct CbvhRayHit one;
    if (args->valid[i] == 0) continue;
    for (word = 0; word < CBVH_RAY_WORDS; word++) *cbvhWordOf(&one.ray, 1, word, 0) = *cbvhWordOf(rays, N, word, i);
    one.hit.geomID = one.hit.instID = RTC_INVALID_GEOMETRY_ID;
    if (!cbvhIntersect1(group, &one, &query)) continue;
    *cbvhWordOf(rays, N, CBVH_RAY_TFAR, i) = *cbvhWordOf(&one.ray, 1, CBVH_RAY_TFAR, 0);
    for (word = 0; word < CBVH_HIT_INST_ID; word++) *cbvhWordOf(hits, N, word, i) = *cbvhWordOf(&one.hit, 1, word, 0);
    cbvhNameHit(hits, N, i, group, args->geomID, args->context);
  }
}

static inline void cbvhOccludedGeometry(const struct RTCOccludedFunctionNArguments* args, unsigned int flags)
{
  const CbvhGroup group = (CbvhGroup)args->geometryUserPtr;
  const unsigned int N = args->N;
  CbvhWord* const rays = (CbvhWord*)args->ray;
  struct CbvhQuery query;
  struct CbvhFilterCall call;
  unsigned int i, word;
  cbvhStartQuery(&query, &call, args, group, args->geomID, args->context, flags, 1);
  if (N == 1) {
    if (args->valid[0]) cbvhOccluded1(group, (struct CbvhRay*)rays, &query);
    return;
  }
  if (N == 4 || N == 8 || N == 16) {
    query.flags |= cbvhFlagsOfPacket(rays, N, args->valid);
    if (N == 4) cbvhOccluded4(group, args->valid, rays, &query);
    else if (N == 8) cbvhOccluded8(group, args->valid, rays, &query);
    else cbvhOccluded16(group, args->valid, rays, &query);
    return;
  }
  for (i = 0; i < N; i++) {
    struct CbvhRay one;
    if (args->valid[i] == 0) continue;
    for (word = 0; word < CBVH_RAY_WORDS; word++) *cbvhWordOf(&one, 1, word, 0) = *cbvhWordOf(rays, N, word, i);
    if (cbvhOccluded1(group, &one, &query)) *cbvhWordOf(rays, N, CBVH_RAY_TFAR, i) = *cbvhWordOf(&one, 1, CBVH_RAY_TFAR, 0);
  }
}

static inline void cbvhIntersectPlain(const struct RTCIntersectFunctionNArguments* args) { cbvhIntersectGeometry(args, 0); }
static inline void cbvhOccludedPlain(const struct RTCOccludedFunctionNArguments* args) { cbvhOccludedGeometry(args, 0); }
static inline void cbvhIntersectFiltered(const struct RTCIntersectFunctionNArguments* args) { cbvhIntersectGeometry(args, CBVH_GEOMETRY_FILTERS); }
static inline void cbvhOccludedFiltered(const struct RTCOccludedFunctionNArguments* args) { cbvhOccludedGeometry(args, CBVH_GEOMETRY_FILTERS); }
#if RTC_VERSION_MAJOR >= 4
static inline void cbvhIntersectContext(const struct RTCIntersectFunctionNArguments* args) { cbvhIntersectGeometry(args, CBVH_GEOMETRY_CONTEXT_FILTERS); }
static inline void cbvhOccludedContext(const struct RTCOccludedFunctionNArguments* args) { cbvhOccludedGeometry(args, CBVH_GEOMETRY_CONTEXT_FILTERS); }
static inline void cbvhIntersectBoth(const struct RTCIntersectFunctionNArguments* args) { cbvhIntersectGeometry(args, CBVH_GEOMETRY_FILTERS | CBVH_GEOMETRY_CONTEXT_FILTERS); }
static inline void cbvhOccludedBoth(const struct RTCOccludedFunctionNArguments* args) { cbvhOccludedGeometry(args, CBVH_GEOMETRY_FILTERS | CBVH_GEOMETRY_CONTEXT_FILTERS); }
#endif

static inline void cbvhBoundGeometry(const struct RTCBoundsFunctionArguments* args)
{
  float lower[3], upper[3];
  cbvhGetGroupBounds((CbvhGroup)args->geometryUserPtr, lower, upper);
  args->bounds_o->lower_x = lower[0]; args->bounds_o->lower_y = lower[1]; args->bounds_o->lower_z = lower[2];
  args->bounds_o->upper_x = upper[0]; args->bounds_o->upper_y = upper[1]; args->bounds_o->upper_z = upper[2];
}

/* Makes a geometry of a group, committed. flags: of CbvhGeometryFlags. The geometry's user data is the group: what an application keeps with it goes to
 * cbvhSetGroupUserPtr. The caller releases the geometry, and the group behind it. Returns NULL if Embree makes none, with its device's error, and if
 * the group has more primitives than primID of a hit counts, 2^32. */
static inline RTCGeometry cbvhNewGeometry(RTCDevice device, CbvhGroup group, unsigned int flags)
{
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  RTCIntersectFunctionN intersect = cbvhIntersectPlain;
  RTCOccludedFunctionN occluded = cbvhOccludedPlain;
  if (!geometry) return NULL;
  if (cbvhGetGroupFirstPrimitive(group, cbvhGetGroupSize(group)) == 0xFFFFFFFFu) { rtcReleaseGeometry(geometry); return NULL; }
  if (flags == CBVH_GEOMETRY_FILTERS) { intersect = cbvhIntersectFiltered; occluded = cbvhOccludedFiltered; }
#if RTC_VERSION_MAJOR >= 4
  if (flags == CBVH_GEOMETRY_CONTEXT_FILTERS) { intersect = cbvhIntersectContext; occluded = cbvhOccludedContext; }
  if (flags == (CBVH_GEOMETRY_FILTERS | CBVH_GEOMETRY_CONTEXT_FILTERS)) { intersect = cbvhIntersectBoth; occluded = cbvhOccludedBoth; }
#endif
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryUserData(geometry, group);
  rtcSetGeometryBoundsFunction(geometry, cbvhBoundGeometry, NULL);
  rtcSetGeometryIntersectFunction(geometry, intersect);
  rtcSetGeometryOccludedFunction(geometry, occluded);
  rtcCommitGeometry(geometry);
  return geometry;
}

#if defined(__cplusplus)
}
#endif

#endif
