// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The models that programs make by name, and those they read from files. */

#include "surface/model.h"

#include <optional>
#include <string>
#include <vector>

namespace cbvh {

struct SceneSettings
{
  std::string scene;              // one of sceneNames(); empty: a cage
  std::string cagePath;           // OBJ
  std::string heightPath;         // height map of the cage, empty: not displaced
  std::optional<float> amplitude; // fraction of the cage's bounding-box diagonal, none: the scene's own
  bool rough = false;             // trex and herd: five times the amplitude
  std::string mapping;            // trex and herd: "faces", the default, or "atlas"
  std::optional<int> count;       // herd: of copies
  std::string mapFolder;          // where generated height maps are kept, empty: the user's cache
  int threads = 0;                // for generating them, 0 for all
};

const std::vector<std::string>& sceneNames();

/* "cube, trex and so on", for help and messages. */
std::string listOfScenes();

/* Checks the names and that settings go together, without making anything. Throws
 * Error that names the option. */
void validateScene(const SceneSettings& settings);

/* Makes or reads a model and validates its cage. warning: set to one line when
 * something about it should be known, untouched otherwise. Throws Error, Cancelled. */
Model loadScene(const SceneSettings& settings, std::string& warning);

} // namespace cbvh
