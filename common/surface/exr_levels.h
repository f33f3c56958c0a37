// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* OpenEXR instead of OpenImageIO, which does not report the kind of an image's levels. */

#include <string>

namespace programs {

/* True if a part of this OpenEXR file has rip map levels: OpenImageIO reads only their first level correctly. False for
 * files that OpenEXR cannot read. */
bool hasRipMaps(const std::string& path);

} // namespace programs
