// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Files that are named on the command line or dropped on a window. */

#include "scenes/catalogue.h"

#include <string>
#include <vector>

namespace cbvh {

/* What to load when files are opened: one file of compressed surfaces (.cbvh), or one cage
 * (OBJ), one height map (any other file), or both of these in any order. A cage comes without
 * the map that was there before; a map goes on the cage that is there.
 *
 * current: what is loaded, or nothing that has a name.
 * Throws Error for more than one of any, for a map without a cage, and for compressed surfaces with either. */
SceneSettings openFiles(const std::vector<std::string>& paths, const SceneSettings& current);

/* The same for files that a command line has without an option before them, beside what its options say.
 * Throws Error, also where both name a model or a map. */
void nameFiles(const std::vector<std::string>& files, SceneSettings& scene);

} // namespace cbvh
