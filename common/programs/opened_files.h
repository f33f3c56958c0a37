// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Files that are named on the command line or dropped onto a window. */

#include "scenes/catalogue.h"

#include <string>
#include <vector>

namespace cbvh {

/* Returns the settings for opening files: one file of compressed surfaces (.cbvh), or one cage (OBJ), one height map
 * (any other file), or a cage and a map in any order. A cage resets the current map; a map alone is for the current
 * cage. `current` describes the loaded model; its names may be empty.
 * Throws Error for more than one file of a kind, a map without a cage, and compressed surfaces with other files. */
SceneSettings openFiles(const std::vector<std::string>& paths, const SceneSettings& current);

/* Adds files without an option from the command line to the settings from its options. Throws Error as openFiles, and
 * if both name a model or a map. */
void applyFileArguments(const std::vector<std::string>& files, SceneSettings& scene);

} // namespace cbvh
