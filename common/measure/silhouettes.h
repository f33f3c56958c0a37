// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* If a ray passes a silhouette in only one of two representations, its error is the distance between two sheets.
 * Other rays show the errors of the surface itself. */

#include "building/surface_hit.h"
#include "tracing/camera.h"
#include "tracing/ray.h"

#include <cstddef>
#include <vector>

namespace programs {

/* Indices of hits whose 3 x 3 neighbors all see the plane of the hit, to 3 pixel widths along their rays. Excludes
 * the border of the picture. `primary` and `hits` hold one entry per pixel, in rows. */
std::vector<size_t> hitsAwayFromSilhouettes(const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits,
                                            const Camera& camera);

} // namespace programs
