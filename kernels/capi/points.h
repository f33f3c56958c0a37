// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Arguments and results of queries for closest points. */

#include "context.h"

#include "cbvh/base/point_on_surface.h"

#include <cmath>
#include <cstdio>

namespace embree { namespace capi {

inline CbvhClosestPoint toPublic(const cbvh::PointOnSurface& from) {
  return {from.p[0],  from.p[1], from.p[2], from.distance, from.Ng[0], from.Ng[1],
          from.Ng[2], from.u,    from.v,    from.primID,   from.geomID};
}

/* Throws for a point or a radius that no query accepts. */
inline void checkPoint(const float p[3], float radius) {
  const float largest = 1e18f; // as coordinates of rays
  for (int k = 0; k < 3; k++)
    if (!(std::fabs(p[k]) <= largest)) {
      char text[96];
      std::snprintf(text, sizeof(text), "the point has the coordinate %g: expected -1e18 to 1e18", double(p[k]));
      throw Failure{CBVH_ERROR_INVALID_ARGUMENT, text};
    }
  require(radius >= 0, "the radius is negative or NaN: expected at least 0");
}

/* Runs cbvhPointQuery in a scene. Throws Failure or an error of the kernels. */
bool queryPoint(RTCScene scene, const CbvhPointQuery* query, CbvhClosestPoint* closest);

}} // namespace embree::capi
