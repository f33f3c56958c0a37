// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* GDAL's TIFF tag 42113 marks missing samples; OpenImageIO does not report it. */

#include <string>
#include <vector>

namespace programs {

/* Returns the tag's text for each page of a TIFF or BigTIFF, or empty. Stops at the first malformed page. Returns
 * nothing for other files, whose errors OpenImageIO reports. */
std::vector<std::string> readGdalNodata(const std::string& path);

} // namespace programs
