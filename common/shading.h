// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Turns hits and errors into pictures. */

#include "image_output.h"

#include <vector>

namespace cbvh {

/* Two lights and the geometric normal as the representation reports it. Nothing is
 * turned towards the viewer: what faces away is tinted magenta, so that a wrong sign
 * shows. */
Image shadeHits(ImageSize size, const std::vector<Ray>& rays, const std::vector<SurfaceHit>& hits, Vec3f up);

/* The paper's figure 10: from blue, no error, to pink at 5 pixels and beyond; black
 * where the representation hits and the reference misses. Orange is the opposite, a
 * miss; white the background.
 * errors: as pixelErrors makes them. */
Image errorHeatMap(ImageSize size, const std::vector<float>& errors);

} // namespace cbvh
