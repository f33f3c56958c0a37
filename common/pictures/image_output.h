// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Pictures as PNG, and with hits as multi-channel EXR, by file_output.h. */

#include "building/surface_hit.h"
#include "pictures/image.h"
#include "tracing/crop.h"
#include "tracing/ray.h"

#include <string>
#include <vector>

namespace programs {

/* Throws Error with the path. */
void writePng(const std::string& path, const Image& image);

/* Writes a part of a picture of size `whole`: the part is the data window, the picture the display window.
 *
 * Float channels: linear colors R G B; hits of primary rays P.X P.Y P.Z (position), Z (distance along the ray,
 * infinite for a miss), N.X N.Y N.Z (unit geometric normal), u, v; the others are 0 for a miss. The channel primID is
 * SurfaceHit::face, an unsigned integer, 0xffffffff for a miss. The arrays hold one entry per pixel of the part, in
 * rows. Throws Error with the path. */
void writeExr(const std::string& path, ImageSize whole, const Crop& part, const std::vector<Vec3f>& colors,
              const std::vector<Ray>& rays, const std::vector<SurfaceHit>& hits);

} // namespace programs
