// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface/model.h"

#include <optional>
#include <string>
#include <vector>

namespace programs {

struct SceneSettings {
  std::string scene;      // one of sceneNames(); empty for a cage or a mesh
  std::string cagePath;   // OBJ
  std::string meshPath;   // traced without subdivision
  std::string savedPath;  // compressed surfaces without a model, for programs that open them
  std::string up;         // one of upAxes(); empty or "auto": guessed
  std::string heightPath; // empty: not displaced
  MapValues mapValues = MapValues::Heights;
  std::optional<float> midLevel; // this and the next three as in DisplacementMap
  std::string channel;
  Vec2f repeat{1, 1};
  std::optional<TextureWrap> wrap;
  std::optional<float> mapScale;     // world units per unit of the map's values; excludes `amplitude`
  std::optional<float> amplitude;    // fraction of the cage's bounding-box diagonal; default: the scene's
  bool rough = false;                // trex and herd: five times the amplitude
  std::string mapping;               // trex and herd: "faces" (the default) or "atlas"
  std::optional<int> count;          // herd: copies
  std::string mapFolder;             // for generated height maps; empty: the user's cache
  int threads = 0;                   // for generating maps, 0 for all
  std::vector<std::string> cageEnds; // OBJ, at later time steps
  std::string motion;                // one of motionNames(), excludes cageEnds; empty: none
  std::optional<int> steps;          // time steps of `motion`
};

const std::vector<std::string>& sceneNames();

/* "cube, ... and trex". `last` precedes the last name. */
std::string listOfScenes(const std::string& last = " and ");

/* Checks names and combinations of settings. Throws Error with the option. */
void validateScene(const SceneSettings& settings);

/* Default for height maps; vectors have a default scale of 1. */
constexpr float defaultAmplitude = 0.006f;

/* Sets the default amplitude or scale of the map if neither is set and the model is displaced. */
SceneSettings withDefaultAmplitude(SceneSettings settings);

/* Throws Error if vertices that a displacement moves could exceed the coordinates that Embree accepts. amplitude,
 * mapScale, midLevel: as in SceneSettings. */
void validateScale(const std::optional<float>& amplitude, const std::optional<float>& mapScale,
                   const std::optional<float>& midLevel, const Cage& cage);

/* Generates or reads a model and validates its cage. Appends lines to `warnings`. Throws Error. */
Model loadScene(const SceneSettings& settings, std::string& warnings);

} // namespace programs
