// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Where a picture shows silhouettes. A ray that passes one in one representation and not
 * in the other has the distance between two sheets for an error, whatever the
 * representation is like; errors of the others are those of the surface itself. */

#include "building/surface_hit.h"
#include "tracing/camera.h"
#include "tracing/ray.h"

#include <cstddef>
#include <vector>

namespace cbvh {

/* Indices of the hits that are away from silhouettes: where all of 3 x 3 pixels see the
 * plane of the hit in the middle, to 3 pixels along their rays. Those at the rim of the
 * picture are left out.
 *
 * primary, hits: one a pixel, in rows, of the camera. */
std::vector<size_t> hitsAwayFromSilhouettes(const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits,
                                            const Camera& camera);

} // namespace cbvh
