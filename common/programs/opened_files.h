// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Files named on the command line or dropped onto a window. */

#include "scenes/catalogue.h"

#include <string>
#include <vector>

namespace programs {

/* Returns the settings for one file of compressed surfaces (.cbvh) or a mesh (PLY, STL, glTF), or for a cage (OBJ) and
 * a height map (any other file) in any order. A cage resets the current map; a map alone belongs to the current cage.
 * `current` describes the loaded model; its names may be empty. Throws Error for two files of a kind, a map without a
 * cage, and compressed surfaces or a mesh with other files. */
SceneSettings openFiles(const std::vector<std::string>& paths, const SceneSettings& current);

/* Adds file arguments without an option to the settings. Throws Error as openFiles, and if both name a model or a
 * map. */
void applyFileArguments(const std::vector<std::string>& files, SceneSettings& scene);

} // namespace programs
