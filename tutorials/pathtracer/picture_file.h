// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Linear colours as files: EXR as they are, PNG clamped and in sRGB. */

#include "pictures/image.h"

#include <string>
#include <vector>

namespace cbvh {

/* Throws Error that names the option unless a picture can be written there, by the path's extension and folder. */
void validatePicturePath(const std::string& path);

/* Clamps. pixels: linear, rows from the top. */
Image toImage(ImageSize size, const std::vector<Vec3f>& pixels);

/* Writes channels R, G and B of 32 bits as EXR, else what toImage makes of them as PNG; whole or not at all.
 * Throws Error with the path. */
void writePicture(const std::string& path, ImageSize size, const std::vector<Vec3f>& pixels);

} // namespace cbvh
