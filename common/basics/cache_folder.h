// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace programs {

/* $XDG_CACHE_HOME/embree-cbvh or ~/.cache/embree-cbvh; the folder may not exist. Ignores a relative $XDG_CACHE_HOME, as
 * the XDG specification requires. Throws Error if neither variable is an absolute path. */
std::string userCacheFolder();

} // namespace programs
