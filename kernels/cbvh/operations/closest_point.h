// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds the closest points of the compressed surfaces of a scene. */

#include "../base/point_on_surface.h"

namespace embree {
class Scene;

namespace core {
/*! Throws RTC_ERROR_INVALID_OPERATION if the scene changed since its last commit, or has none. */
void requireCommitted(const Scene* scene);

/*! As cbvhPointQuery: finds the point of stored triangles that is closest to p. radius: largest distance. function:
 *  null, or called with the closest point of each triangle within the radius. closest: written if a point is found.
 *  Throws RTC_ERROR_INVALID_OPERATION if geometries near the point, possibly outside of the radius, have no stored
 *  triangles or are in instances; `closest` was then written for the others. The scene must have been committed
 *  once. */
bool findClosestPoint(Scene* scene, const float p[3], float time, float radius, cbvh::PointFunction function,
                      void* userPtr, cbvh::PointOnSurface& closest);
} // namespace core
} // namespace embree
