// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#ifndef CBVH_EMBREE_H
#define CBVH_EMBREE_H

/* Compressed surfaces in the scenes of the Embree that a renderer uses: version 3.13 or 4. The renderer compiles this
 * header with the headers of its Embree, which it includes first.
 *
 *   #include <embree4/rtcore.h>
 *   #include <cbvh/embree.h>
 *
 *   RTCGeometry geometry = cbvhNewGeometry(device, group, 0);
 *   rtcAttachGeometry(scene, geometry);
 *
 * The geometry has the type RTC_GEOMETRY_TYPE_USER and one primitive. The group must be committed before, and must
 * exist as long as the geometry. No thread may trace the scene while the group is committed again. Afterwards, call
 * rtcCommitGeometry and rtcCommitScene to update the bounds.
 *
 * The primIDs of hits number the primitives of all surfaces of the group consecutively. cbvhFindGroupPrimitive
 * returns the surface and the primitive of such a number.
 *
 * The API consists of cbvhNewGeometry, CbvhGeometryFlags and CbvhFilterContext. All other names in this header are
 * internal and may change in any version. */

#include "cbvh.h"

#if !defined(RTC_VERSION_MAJOR)
#error "include Embree's rtcore.h before cbvh/embree.h"
#endif

#if defined(__cplusplus)
extern "C" {
#endif

/* Flags of cbvhNewGeometry. Without flags, rays are fastest, and no filter functions are called. */
enum CbvhGeometryFlags {
  /* Calls the filter functions of the geometry, with Embree 3 also the filter functions of contexts. Each call has one
   * hit. As in Embree, a filter may change an accepted hit and decrease tfar. Changes of geomID and instID have no
   * effect. */
  CBVH_GEOMETRY_FLAG_FILTERS = 1,
#if RTC_VERSION_MAJOR >= 4
  /* Calls the filter of a CbvhFilterContext, which must be the context of each query that may hit the geometry: Embree
   * 4 does not pass the filter of RTCIntersectArguments to user geometry. */
  CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS = 2,
#endif
};

#if RTC_VERSION_MAJOR >= 4
/* Query context with a filter function, see CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS. Pass the address of `context` to
 * Embree. */
struct CbvhFilterContext {
  struct RTCRayQueryContext context; /* call rtcInitRayQueryContext first */
  RTCFilterFunctionN filter;         /* called with one hit at a time. NULL: every hit counts */
};
typedef struct RTCRayQueryContext CbvhInternalContext;
#else
typedef struct RTCIntersectContext CbvhInternalContext;
#endif

/* --- words of RTCRayN and RTCHitN ------------------------------------------------------------ */

typedef unsigned int __attribute__((may_alias)) CbvhInternalWord;

enum CbvhInternalWords {
  CBVH_INTERNAL_RAY_DIR = 4,
  CBVH_INTERNAL_RAY_TFAR = 8,
  CBVH_INTERNAL_RAY_WORDS = 12,
  /* instIDs of all levels, followed by the primIDs of instances of all levels */
  CBVH_INTERNAL_HIT_PRIM_ID = 5,
  CBVH_INTERNAL_HIT_GEOM_ID = 6,
  CBVH_INTERNAL_HIT_INST_ID = 7
};

static inline CbvhInternalWord* cbvhInternalWordOf(void* of, unsigned int N, unsigned int word, unsigned int i) {
  return (CbvhInternalWord*)of + word * N + i;
}

/* --- IDs of hits ------------------------------------------------------------------------ */

/* Writes the IDs of the application's scene into hit i. hits: an RTCHitN of N hits. */
static inline void cbvhInternalWriteHitIDs(void* hits, unsigned int N, unsigned int i, CbvhGroup group,
                                           unsigned int geomID, const CbvhInternalContext* context) {
  const unsigned int surface = *cbvhInternalWordOf(hits, N, CBVH_INTERNAL_HIT_GEOM_ID, i);
  unsigned int level;
  if (surface != 0)
    *cbvhInternalWordOf(hits, N, CBVH_INTERNAL_HIT_PRIM_ID, i) += cbvhGetGroupFirstPrimitive(group, surface);
  *cbvhInternalWordOf(hits, N, CBVH_INTERNAL_HIT_GEOM_ID, i) = geomID;
  for (level = 0; level < RTC_MAX_INSTANCE_LEVEL_COUNT; level++) {
    *cbvhInternalWordOf(hits, N, CBVH_INTERNAL_HIT_INST_ID + level, i) = context->instID[level];
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
    *cbvhInternalWordOf(hits, N, CBVH_INTERNAL_HIT_INST_ID + RTC_MAX_INSTANCE_LEVEL_COUNT + level, i) =
        context->instPrimID[level];
#endif
  }
}

/* --- filters ----------------------------------------------------------------------------- */

struct CbvhInternalFilterCall {
  const void* args; /* arguments of the callback */
  CbvhGroup group;
  unsigned int geomID;
  CbvhInternalContext* context;
  unsigned int flags;
  int isOcclusion;
};

/* Calls the application's filters for one hit at a time: IDs must be translated, and the application's RTCHit may be
 * larger. Takes over what a filter may change. */
static inline void cbvhInternalFilterHits(const struct CbvhFilterArguments* args) {
  const struct CbvhInternalFilterCall* const call = (const struct CbvhInternalFilterCall*)args->userPtr;
  unsigned int i, word, firstPrimitive;
  for (i = 0; i < args->count; i++) {
    struct RTCFilterFunctionNArguments filter;
    struct RTCRay ray;
    struct RTCHit hit;
    int valid = -1;
    if (args->valid[i] == 0) continue;
    for (word = 0; word < CBVH_INTERNAL_RAY_WORDS; word++)
      *cbvhInternalWordOf(&ray, 1, word, 0) = *cbvhInternalWordOf(args->rays, args->count, word, i);
    for (word = 0; word < CBVH_INTERNAL_HIT_INST_ID; word++)
      *cbvhInternalWordOf(&hit, 1, word, 0) = *cbvhInternalWordOf(args->hits, args->count, word, i);
    firstPrimitive = 0u - hit.primID;
    cbvhInternalWriteHitIDs(&hit, 1, 0, call->group, call->geomID, call->context);
    firstPrimitive += hit.primID; /* what it has added */
    filter.valid = &valid;
    filter.geometryUserPtr = call->group;
    filter.context = call->context;
    filter.ray = (struct RTCRayN*)&ray;
    filter.hit = (struct RTCHitN*)&hit;
    filter.N = 1;
    if (call->flags & CBVH_GEOMETRY_FLAG_FILTERS) {
#if RTC_VERSION_MAJOR >= 4
      if (call->isOcclusion)
        rtcInvokeOccludedFilterFromGeometry((const struct RTCOccludedFunctionNArguments*)call->args, &filter);
      else rtcInvokeIntersectFilterFromGeometry((const struct RTCIntersectFunctionNArguments*)call->args, &filter);
#else
      if (call->isOcclusion) rtcFilterOcclusion((const struct RTCOccludedFunctionNArguments*)call->args, &filter);
      else rtcFilterIntersection((const struct RTCIntersectFunctionNArguments*)call->args, &filter);
#endif
    }
#if RTC_VERSION_MAJOR >= 4
    if (valid && (call->flags & CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS)) {
      const struct CbvhFilterContext* const query = (const struct CbvhFilterContext*)call->context;
      if (query->filter) query->filter(&filter);
    }
#endif
    if (!valid) {
      args->valid[i] = 0;
      continue;
    }
    *cbvhInternalWordOf(args->rays, args->count, CBVH_INTERNAL_RAY_TFAR, i) =
        *cbvhInternalWordOf(&ray, 1, CBVH_INTERNAL_RAY_TFAR, 0);
    hit.primID -= firstPrimitive; /* the caller adds it again */
    for (word = 0; word <= CBVH_INTERNAL_HIT_PRIM_ID; word++)
      *cbvhInternalWordOf(args->hits, args->count, word, i) = *cbvhInternalWordOf(&hit, 1, word, 0);
  }
}

/* --- callbacks of the geometry ------------------------------------------------------------ */

/* Returns CBVH_QUERY_FLAG_COHERENT if more than half of the rays of a packet are active and all of these have the same
 * signs of directions. */
static inline unsigned int cbvhInternalPacketFlags(void* rays, unsigned int N, const int* valid) {
  unsigned int axis, i, count = 0, negative[3] = {0, 0, 0};
  for (i = 0; i < N; i++) {
    if (valid[i] == 0) continue;
    count++;
    for (axis = 0; axis < 3; axis++)
      negative[axis] += *cbvhInternalWordOf(rays, N, CBVH_INTERNAL_RAY_DIR + axis, i) >> 31;
  }
  if (2 * count <= N) return 0;
  for (axis = 0; axis < 3; axis++)
    if (negative[axis] != 0 && negative[axis] != count) return 0;
  return CBVH_QUERY_FLAG_COHERENT;
}

static inline void cbvhInternalStartQuery(struct CbvhQuery* query, struct CbvhInternalFilterCall* call,
                                          const void* args, CbvhGroup group, unsigned int geomID,
                                          CbvhInternalContext* context, unsigned int flags, int isOcclusion) {
  query->structSize = sizeof(*query);
  query->flags = 0;
  query->filter = flags ? cbvhInternalFilterHits : NULL;
  query->filterUserPtr = call;
  if (flags) {
    call->args = args;
    call->group = group;
    call->geomID = geomID;
    call->context = context;
    call->flags = flags;
    call->isOcclusion = isOcclusion;
  }
#if RTC_VERSION_MAJOR < 4
  if (context->flags & RTC_INTERSECT_CONTEXT_FLAG_COHERENT) query->flags = CBVH_QUERY_FLAG_COHERENT;
#endif
}

static inline void cbvhInternalIntersect(const struct RTCIntersectFunctionNArguments* args, unsigned int flags) {
  const CbvhGroup group = (CbvhGroup)args->geometryUserPtr;
  const unsigned int N = args->N;
  CbvhInternalWord* const rays = (CbvhInternalWord*)args->rayhit;
  CbvhInternalWord* const hits = rays + CBVH_INTERNAL_RAY_WORDS * N;
  struct CbvhQuery query;
  struct CbvhInternalFilterCall call;
  unsigned int i, word, found = 0;
  cbvhInternalStartQuery(&query, &call, args, group, args->geomID, args->context, flags, 0);
  if (N == 1) {
    if (args->valid[0] && cbvhIntersect1(group, (struct CbvhRayHit*)rays, &query))
      cbvhInternalWriteHitIDs(hits, 1, 0, group, args->geomID, args->context);
    return;
  }
  if (N == 4 || N == 8 || N == 16) {
    query.flags |= cbvhInternalPacketFlags(rays, N, args->valid);
    if (N == 4) found = cbvhIntersect4(group, args->valid, rays, &query);
    else if (N == 8) found = cbvhIntersect8(group, args->valid, rays, &query);
    else found = cbvhIntersect16(group, args->valid, rays, &query);
    for (i = 0; i < N; i++)
      if (found & (1u << i)) cbvhInternalWriteHitIDs(hits, N, i, group, args->geomID, args->context);
    return;
  }
  for (i = 0; i < N; i++) {
    struct CbvhRayHit one;
    if (args->valid[i] == 0) continue;
    for (word = 0; word < CBVH_INTERNAL_RAY_WORDS; word++)
      *cbvhInternalWordOf(&one.ray, 1, word, 0) = *cbvhInternalWordOf(rays, N, word, i);
    one.hit.geomID = one.hit.instID = RTC_INVALID_GEOMETRY_ID;
    if (!cbvhIntersect1(group, &one, &query)) continue;
    *cbvhInternalWordOf(rays, N, CBVH_INTERNAL_RAY_TFAR, i) =
        *cbvhInternalWordOf(&one.ray, 1, CBVH_INTERNAL_RAY_TFAR, 0);
    for (word = 0; word < CBVH_INTERNAL_HIT_INST_ID; word++)
      *cbvhInternalWordOf(hits, N, word, i) = *cbvhInternalWordOf(&one.hit, 1, word, 0);
    cbvhInternalWriteHitIDs(hits, N, i, group, args->geomID, args->context);
  }
}

static inline void cbvhInternalOccluded(const struct RTCOccludedFunctionNArguments* args, unsigned int flags) {
  const CbvhGroup group = (CbvhGroup)args->geometryUserPtr;
  const unsigned int N = args->N;
  CbvhInternalWord* const rays = (CbvhInternalWord*)args->ray;
  struct CbvhQuery query;
  struct CbvhInternalFilterCall call;
  unsigned int i, word;
  cbvhInternalStartQuery(&query, &call, args, group, args->geomID, args->context, flags, 1);
  if (N == 1) {
    if (args->valid[0]) cbvhOccluded1(group, (struct CbvhRay*)rays, &query);
    return;
  }
  if (N == 4 || N == 8 || N == 16) {
    query.flags |= cbvhInternalPacketFlags(rays, N, args->valid);
    if (N == 4) cbvhOccluded4(group, args->valid, rays, &query);
    else if (N == 8) cbvhOccluded8(group, args->valid, rays, &query);
    else cbvhOccluded16(group, args->valid, rays, &query);
    return;
  }
  for (i = 0; i < N; i++) {
    struct CbvhRay one;
    if (args->valid[i] == 0) continue;
    for (word = 0; word < CBVH_INTERNAL_RAY_WORDS; word++)
      *cbvhInternalWordOf(&one, 1, word, 0) = *cbvhInternalWordOf(rays, N, word, i);
    if (cbvhOccluded1(group, &one, &query))
      *cbvhInternalWordOf(rays, N, CBVH_INTERNAL_RAY_TFAR, i) = *cbvhInternalWordOf(&one, 1, CBVH_INTERNAL_RAY_TFAR, 0);
  }
}

static inline void cbvhInternalIntersectPlain(const struct RTCIntersectFunctionNArguments* args) {
  cbvhInternalIntersect(args, 0);
}

static inline void cbvhInternalOccludedPlain(const struct RTCOccludedFunctionNArguments* args) {
  cbvhInternalOccluded(args, 0);
}

static inline void cbvhInternalIntersectFiltered(const struct RTCIntersectFunctionNArguments* args) {
  cbvhInternalIntersect(args, CBVH_GEOMETRY_FLAG_FILTERS);
}

static inline void cbvhInternalOccludedFiltered(const struct RTCOccludedFunctionNArguments* args) {
  cbvhInternalOccluded(args, CBVH_GEOMETRY_FLAG_FILTERS);
}
#if RTC_VERSION_MAJOR >= 4
static inline void cbvhInternalIntersectContext(const struct RTCIntersectFunctionNArguments* args) {
  cbvhInternalIntersect(args, CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS);
}

static inline void cbvhInternalOccludedContext(const struct RTCOccludedFunctionNArguments* args) {
  cbvhInternalOccluded(args, CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS);
}

static inline void cbvhInternalIntersectBoth(const struct RTCIntersectFunctionNArguments* args) {
  cbvhInternalIntersect(args, CBVH_GEOMETRY_FLAG_FILTERS | CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS);
}

static inline void cbvhInternalOccludedBoth(const struct RTCOccludedFunctionNArguments* args) {
  cbvhInternalOccluded(args, CBVH_GEOMETRY_FLAG_FILTERS | CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS);
}
#endif

static inline void cbvhInternalBounds(const struct RTCBoundsFunctionArguments* args) {
  float lower[3], upper[3];
  cbvhGetGroupBounds((CbvhGroup)args->geometryUserPtr, lower, upper);
  args->bounds_o->lower_x = lower[0];
  args->bounds_o->lower_y = lower[1];
  args->bounds_o->lower_z = lower[2];
  args->bounds_o->upper_x = upper[0];
  args->bounds_o->upper_y = upper[1];
  args->bounds_o->upper_z = upper[2];
}

/* Creates a geometry from a group, and commits it. The caller owns the geometry: it releases the geometry first, and
 * then the group, which the geometry does not retain. rtcSetGeometryUserData must not be called for it.
 *
 * device: of the application's Embree.
 * group:  committed; the function does not check this. It becomes the user data of the geometry: use
 *         cbvhSetGroupUserPtr for a pointer of the application.
 * flags:  bits of CbvhGeometryFlags.
 *
 * Returns NULL if Embree cannot create the geometry: the device then has an error. Also returns NULL if the group is
 * NULL, or if cbvhCheckGeometry finds unknown flags or too many primitives: cbvhGetErrorText then returns the reason.
 *
 * Thread safety: as rtcNewGeometry. */
static inline RTCGeometry cbvhNewGeometry(RTCDevice device, CbvhGroup group, unsigned int flags) {
  RTCGeometry geometry;
  RTCIntersectFunctionN intersect = cbvhInternalIntersectPlain;
  RTCOccludedFunctionN occluded = cbvhInternalOccludedPlain;
#if RTC_VERSION_MAJOR >= 4
  const unsigned int known = CBVH_GEOMETRY_FLAG_FILTERS | CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS;
#else
  const unsigned int known = CBVH_GEOMETRY_FLAG_FILTERS;
#endif
  if (cbvhCheckGeometry(group, flags, known) != CBVH_OK) return NULL;
  geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  if (!geometry) return NULL;
  if (flags == CBVH_GEOMETRY_FLAG_FILTERS) {
    intersect = cbvhInternalIntersectFiltered;
    occluded = cbvhInternalOccludedFiltered;
  }
#if RTC_VERSION_MAJOR >= 4
  if (flags == CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS) {
    intersect = cbvhInternalIntersectContext;
    occluded = cbvhInternalOccludedContext;
  }
  if (flags == (CBVH_GEOMETRY_FLAG_FILTERS | CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS)) {
    intersect = cbvhInternalIntersectBoth;
    occluded = cbvhInternalOccludedBoth;
  }
#endif
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryUserData(geometry, group);
  rtcSetGeometryBoundsFunction(geometry, cbvhInternalBounds, NULL);
  rtcSetGeometryIntersectFunction(geometry, intersect);
  rtcSetGeometryOccludedFunction(geometry, occluded);
  rtcCommitGeometry(geometry);
  return geometry;
}

#if defined(__cplusplus)
}
#endif

#endif
