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

#if RTC_MAX_INSTANCE_LEVEL_COUNT > 32
#error "expected RTC_MAX_INSTANCE_LEVEL_COUNT of at most 32"
#endif

/* --- callbacks: they convert arguments for cbvhIntersectGeometry and cbvhOccludedGeometry ----- */

struct CbvhInternalCall {
  const void* args; /* arguments of the callback */
  CbvhGroup group;
  CbvhInternalContext* context;
  unsigned int flags;
  int isOcclusion;
};

/* A CbvhGeometryFilterFunction that calls the filters that the flags of the geometry select. */
static inline void cbvhInternalFilter(void* userPtr, int* valid, void* ray, void* hit) {
  const struct CbvhInternalCall* const call = (const struct CbvhInternalCall*)userPtr;
  struct RTCFilterFunctionNArguments filter;
  filter.valid = valid;
  filter.geometryUserPtr = call->group;
  filter.context = call->context;
  filter.ray = (struct RTCRayN*)ray;
  filter.hit = (struct RTCHitN*)hit;
  filter.N = 1;
#if RTC_VERSION_MAJOR >= 4
  if (call->flags & CBVH_GEOMETRY_FLAG_FILTERS) {
    if (call->isOcclusion)
      rtcInvokeOccludedFilterFromGeometry((const struct RTCOccludedFunctionNArguments*)call->args, &filter);
    else rtcInvokeIntersectFilterFromGeometry((const struct RTCIntersectFunctionNArguments*)call->args, &filter);
  }
  if (*valid && (call->flags & CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS)) {
    const struct CbvhFilterContext* const query = (const struct CbvhFilterContext*)call->context;
    if (query->filter) query->filter(&filter);
  }
#else
  if (call->isOcclusion) rtcFilterOcclusion((const struct RTCOccludedFunctionNArguments*)call->args, &filter);
  else rtcFilterIntersection((const struct RTCIntersectFunctionNArguments*)call->args, &filter);
#endif
}

/* call: passed to the filter. */
static inline struct CbvhGeometryQuery cbvhInternalQuery(struct CbvhInternalCall* call, const int* valid, void* rays,
                                                         unsigned int N, unsigned int geomID) {
  struct CbvhGeometryQuery query;
  query.group = call->group;
  query.valid = valid;
  query.rays = rays;
  query.N = N;
  query.flags = 0;
  query.geomID = geomID;
  query.numLevels = RTC_MAX_INSTANCE_LEVEL_COUNT;
  query.instIDs = call->context->instID;
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  query.instPrimIDs = call->context->instPrimID;
#else
  query.instPrimIDs = NULL;
#endif
#if RTC_VERSION_MAJOR < 4
  if (call->context->flags & RTC_INTERSECT_CONTEXT_FLAG_COHERENT) query.flags = CBVH_QUERY_FLAG_COHERENT;
#endif
  query.filter = call->flags ? cbvhInternalFilter : NULL;
  query.filterUserPtr = call;
  return query;
}

/* Defines the callbacks of a geometry with these flags. */
#define CBVH_INTERNAL_CALLBACKS(name, geometryFlags) \
  static inline void cbvhInternalIntersect##name(const struct RTCIntersectFunctionNArguments* args) { \
    struct CbvhInternalCall call = {args, (CbvhGroup)args->geometryUserPtr, args->context, geometryFlags, 0}; \
    const struct CbvhGeometryQuery query = cbvhInternalQuery(&call, args->valid, args->rayhit, args->N, args->geomID); \
    cbvhIntersectGeometry(&query); \
  } \
  static inline void cbvhInternalOccluded##name(const struct RTCOccludedFunctionNArguments* args) { \
    struct CbvhInternalCall call = {args, (CbvhGroup)args->geometryUserPtr, args->context, geometryFlags, 1}; \
    const struct CbvhGeometryQuery query = cbvhInternalQuery(&call, args->valid, args->ray, args->N, args->geomID); \
    cbvhOccludedGeometry(&query); \
  }

CBVH_INTERNAL_CALLBACKS(Plain, 0)
CBVH_INTERNAL_CALLBACKS(Filtered, CBVH_GEOMETRY_FLAG_FILTERS)
#if RTC_VERSION_MAJOR >= 4
CBVH_INTERNAL_CALLBACKS(Context, CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS)
CBVH_INTERNAL_CALLBACKS(Both, CBVH_GEOMETRY_FLAG_FILTERS | CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS)
#endif
#undef CBVH_INTERNAL_CALLBACKS

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
  static const RTCIntersectFunctionN intersect[] = {
      cbvhInternalIntersectPlain,
      cbvhInternalIntersectFiltered,
#if RTC_VERSION_MAJOR >= 4
      cbvhInternalIntersectContext,
      cbvhInternalIntersectBoth,
#endif
  };
  static const RTCOccludedFunctionN occluded[] = {
      cbvhInternalOccludedPlain,
      cbvhInternalOccludedFiltered,
#if RTC_VERSION_MAJOR >= 4
      cbvhInternalOccludedContext,
      cbvhInternalOccludedBoth,
#endif
  };
  RTCGeometry geometry;
  if (cbvhCheckGeometry(group, flags, sizeof(intersect) / sizeof(*intersect) - 1) != CBVH_OK) return NULL;
  geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  if (!geometry) return NULL;
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryUserData(geometry, group);
  rtcSetGeometryBoundsFunction(geometry, cbvhInternalBounds, NULL);
  rtcSetGeometryIntersectFunction(geometry, intersect[flags]);
  rtcSetGeometryOccludedFunction(geometry, occluded[flags]);
  rtcCommitGeometry(geometry);
  return geometry;
}

#if defined(__cplusplus)
}
#endif

#endif
