// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Images that OpenImageIO (2.4 to 3.1) reads incorrectly without an error, and images that are no maps. */

#include <OpenImageIO/imageio.h>

#include <string>

namespace programs {

/* Returns the reason not to read the current image of `source`, with what is expected instead, or empty. isInverted:
 * see MapImage. */
std::string rejectionOf(OIIO::ImageInput& source, const std::string& path, bool isInverted);

/* True if OpenImageIO normalizes samples of this type to 0..1. */
bool isUnsigned(OIIO::TypeDesc type);

} // namespace programs
