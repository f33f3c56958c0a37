// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "pictures/image.h"

#include <string>
#include <vector>

namespace programs {

/* Throws Error with the option unless the extension is .exr or .png and the folder exists. */
void validatePicturePath(const std::string& path);

/* Converts linear pixels, rows from the top, to sRGB; clamps to [0,1]. */
Image toImage(ImageSize size, const std::vector<Vec3f>& pixels);

/* Writes linear pixels as EXR with 32-bit channels R, G and B, or as PNG in sRGB, completely or not at all. Throws
 * Error with the path. */
void writePicture(const std::string& path, ImageSize size, const std::vector<Vec3f>& pixels);

} // namespace programs
