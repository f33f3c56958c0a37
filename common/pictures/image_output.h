// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Pictures: PNG through OpenImageIO, colours and hits as multi-channel EXR through OpenEXR. Both
 * appear under their names complete or not at all. */

#include "building/surface_hit.h"
#include "pictures/image.h"
#include "tracing/crop.h"
#include "tracing/ray.h"

#include <string>
#include <vector>

namespace cbvh {

/* Throws Error with the path. */
void writePng(const std::string& path, const Image& image);

/* Writes a part of a picture that is `whole` large as what OpenEXR calls a crop window: its pixels are the data window, the display window is the whole.
 * colors: linear, float channels R G B. hits: of primary rays, float channels P.X P.Y P.Z (hit point), Z (distance
 * along the ray, infinite where it misses), N.X N.Y N.Z (geometric normal of length
 * 1), u, v, and primID as an unsigned integer (0xffffffff where it misses), which a
 * float cannot hold. Throws Error with the path. */
void writeExr(const std::string& path, ImageSize whole, const Crop& part, const std::vector<Vec3f>& colors, const std::vector<Ray>& rays,
              const std::vector<SurfaceHit>& hits);

} // namespace cbvh
