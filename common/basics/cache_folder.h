// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Where programs keep what they can make again. */

#include <string>

namespace cbvh {

/* $XDG_CACHE_HOME/embree-cbvh or ~/.cache/embree-cbvh, whether it is there or not. As the
 * XDG base directory specification says, a relative $XDG_CACHE_HOME does not count.
 * Throws Error when neither variable is set. */
std::string userCacheFolder();

} // namespace cbvh
