// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <OpenImageIO/imageio.h>

#include <string>

namespace programs {

/* Writes an image, completely or not at all. The extension selects the format; the default is PNG. `type` describes
 * `pixels`. Throws Error with the path. */
void writeImageFile(const std::string& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* pixels);

/* Throws Error with the path if OpenImageIO cannot write the format that the extension selects. */
void requireImageFormat(const std::string& path);

} // namespace programs
