// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The folder for files that programs can generate again. */

#include <string>

namespace cbvh {

/* Returns $XDG_CACHE_HOME/embree-cbvh or ~/.cache/embree-cbvh; the folder may not exist. A relative $XDG_CACHE_HOME
 * is ignored, as the XDG base directory specification requires. Throws Error if neither variable is an absolute
 * path. */
std::string userCacheFolder();

} // namespace cbvh
