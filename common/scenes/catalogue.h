// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Models that programs generate by name or read from files. */

#include "surface/model.h"

#include <optional>
#include <string>
#include <vector>

namespace cbvh {

struct SceneSettings
{
  std::string scene;      // one of sceneNames(); empty for a cage or a mesh
  std::string cagePath;   // OBJ
  std::string meshPath;   // OBJ of a mesh that is traced without subdivision
  std::string savedPath;  // file of compressed surfaces without a model; only for programs that open such files
  std::string up;         // up axis of the cage, one of upAxes(); empty or "auto": guessed
  std::string heightPath; // displacement map of the cage; empty: not displaced
  MapValues mapValues = MapValues::Heights;
  std::optional<float> midLevel; // midLevel, channel and repeat as in DisplacementMap
  std::string channel;
  Vec2f repeat{1, 1};
  std::optional<float> mapScale;  // world units per unit of the map's values, instead of an amplitude
  std::optional<float> amplitude; // fraction of the cage's bounding-box diagonal; default: the scene's own
  bool rough = false;             // trex and herd: five times the amplitude
  std::string mapping;            // trex and herd: "faces" (the default) or "atlas"
  std::optional<int> count;       // herd: number of copies
  std::string mapFolder;          // folder for generated height maps; empty: the user's cache
  int threads = 0;                // for generating maps, 0 for all
  std::vector<std::string> cageEnds; // OBJ files of the cage at later time steps
  std::string motion;                // instead of cageEnds, one of motionNames(); empty: static
  std::optional<int> steps;          // number of time steps of `motion`
};

const std::vector<std::string>& sceneNames();

/* Returns "cube, ... and trex" for help texts and messages. `last` precedes the last name. */
std::string listOfScenes(const std::string& last = " and ");

/* Checks names and combinations of settings without creating anything. Throws Error that names the option. */
void validateScene(const SceneSettings& settings);

/* Default for height maps of cages. Vectors have a default scale of 1 instead. */
constexpr float defaultAmplitude = 0.006f;

/* Returns the settings with the default amplitude or scale of the map if neither is set, as loadScene uses them.
 * Changes nothing if nothing is displaced. */
SceneSettings withDefaultAmplitude(SceneSettings settings);

/* Generates or reads a model and validates its cage. Appends lines to `warnings` for probable mistakes. Throws Error. */
Model loadScene(const SceneSettings& settings, std::string& warnings);

} // namespace cbvh
