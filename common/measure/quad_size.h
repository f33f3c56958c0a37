// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/surface_hit.h"
#include "tracing/image_size.h"

#include <vector>

namespace programs {

/* Returns the median edge length of quads in a picture, in pixels, or 0 if too few adjacent pixels hit the same face.
 * `hits` holds one entry per pixel, in rows; each face has 2^level x 2^level quads. Quads of n-gons count as twice as
 * large. */
float medianQuadSize(ImageSize size, const std::vector<SurfaceHit>& hits, int level);

} // namespace programs
