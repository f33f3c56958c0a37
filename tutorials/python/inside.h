// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decides on which side of a closed surface a point is. */

#include "basics/vec.h"

#include <embree3/rtcore.h>

namespace programs::python {

/* True if the surface encloses the point: rays from it cross the surface an odd number of times. The orientation of
 * triangles does not matter. Two rays must agree, otherwise a third one decides, because a ray through an edge may hit
 * both of its triangles. For surfaces that are not closed, the result depends on the directions of the rays. */
bool isInside(RTCScene scene, Vec3f point, float time);

} // namespace programs::python
