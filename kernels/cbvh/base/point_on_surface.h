// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Result of a query for the closest point (operations/closest_point.h). */

#include <cstdint>

namespace embree::cbvh {
/*! A point of a stored triangle. */
struct PointOnSurface {
  float p[3];
  float distance; //!< from the query's point
  float Ng[3];    //!< normal of the triangle, of any length
  float u, v;
  uint32_t primID, geomID;
};

/*! Called with the closest point of a triangle within the radius. Returns true if the point is accepted: the radius
 *  becomes its distance. radius: may be decreased. */
typedef bool (*PointFunction)(void* userPtr, const PointOnSurface& point, float& radius);
} // namespace embree::cbvh
