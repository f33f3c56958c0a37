// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The value that marks missing samples in a TIFF: tag 42113 of GDAL, which OpenImageIO does not report. */

#include <string>
#include <vector>

namespace cbvh {

/* Returns the text of the tag for each page of a TIFF or BigTIFF, empty for a page without the tag. Stops at the first
 * malformed page. Returns nothing for other files: OpenImageIO reports what is wrong with them. */
std::vector<std::string> readGdalNodata(const std::string& path);

} // namespace cbvh
