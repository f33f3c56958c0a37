// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Images by OpenImageIO's writers. */

#include <OpenImageIO/imageio.h>

#include <string>

namespace cbvh {

/* Writes an image in the format that the path's extension names, PNG without one; whole or not at all.
 * type: of the pixels. Throws Error with the path. */
void writeImageFile(const std::string& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* pixels);

} // namespace cbvh
