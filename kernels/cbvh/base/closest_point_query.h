// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A query for the closest point of compressed surfaces (operations/closest_point.h). It travels as the context of a
 * point query of Embree, which selects the kernels of the instruction set; other trees than ours ignore it. */

#include "codec_names.h"
#include "../embree/point_queries.h"
#include "point_on_surface.h"
#include "../../cvert/rule/rule.h"

namespace embree::cbvh {
struct ClosestPointQuery : public PointQueryContext {
  /*! query: its radius is the largest distance. function: null accepts all points. */
  ClosestPointQuery(Scene* scene, PointQuery* query, RTCPointQueryContext* user, PointFunction function, void* userPtr)
    : PointQueryContext(scene, query, POINT_QUERY_TYPE_SPHERE, mark, user, 1.0f, this),
      function(function),
      functionPtr(userPtr),
      squaredRadius(double(query->radius) * query->radius) {}

  /*! Null for a point query of an application. In instances, `context` is another object. */
  static ClosestPointQuery* of(PointQueryContext* context) {
    return context->func == mark ? (ClosestPointQuery*)context->userPtr : nullptr;
  }

  const PointFunction function;
  void* const functionPtr;
  double squaredRadius;
  bool isFound = false;
  bool hasOthers = false; //!< geometries within the radius have no stored triangles, or are in instances
  PointOnSurface closest; //!< if isFound
  TriangleKey key;        //!< of `closest`

private:
  /*! Value of `func`. Embree calls it for primitives of its own; sets hasOthers. */
  static bool mark(RTCPointQueryFunctionArguments*);
};
} // namespace embree::cbvh
