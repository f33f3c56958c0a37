// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Pictures and rasters that were computed in parts. */

#include "tracing/image_size.h"

#include <optional>
#include <string>
#include <vector>

namespace programs {

/* Joins parts of whole rows, from top to bottom, and writes one image. Pixels keep their bits, channels their types.
 * The extension of `path` selects the format. Throws Error that names a part which cannot be read, has other channels
 * or another width than the first one, or does not continue the part before, as far as its format has positions. Also
 * throws Error if the joined picture does not have the expected size. */
void joinPictures(const std::vector<std::string>& parts, std::optional<ImageSize> size, const std::string& path);

} // namespace programs
