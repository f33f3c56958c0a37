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
  std::string meshPath;           // OBJ, of a mesh that is traced as it is
  std::string savedPath;          // file of compressed surfaces, without the model that they were made of; for programs that open such files
  std::string up;                 // axis of the cage that points upwards, one of upAxes(); empty or "auto": guessed
  std::string heightPath;         // map of the cage's displacement, empty: not displaced
  MapValues mapValues = MapValues::Heights;
  std::optional<float> midLevel;  // as DisplacementMap's, likewise the next two
  std::string channel;
  Vec2f repeat{1, 1};
  std::optional<float> mapScale;  // world units that a difference of 1 moves by, in place of an amplitude
  std::optional<float> amplitude; // fraction of the cage's bounding-box diagonal, none: the scene's own
  bool rough = false;             // trex and herd: five times the amplitude
  std::string mapping;            // trex and herd: "faces", the default, or "atlas"
  std::optional<int> count;       // herd: of copies
  std::string mapFolder;          // where generated height maps are kept, empty: the user's cache
  int threads = 0;                // for generating them, 0 for all
  std::vector<std::string> cageEnds; // OBJ, of the cage at later time steps
  std::string motion;             // in place of these, one of motionNames(); empty: the model does not move
  std::optional<int> steps;       // in time, of that
};

const std::vector<std::string>& sceneNames();

/* "cube, trex and so on", for help and messages. */
std::string listOfScenes();

/* Checks the names and that settings go together, without making anything. Throws
 * Error that names the option. */
void validateScene(const SceneSettings& settings);

/* Of height maps of cages, where none is given; vectors move by their own lengths. */
constexpr float defaultAmplitude = 0.006f;

/* The same with an amplitude or a scale of the map where neither was given: what loadScene
 * takes then. Nothing is added where nothing is displaced. */
SceneSettings withStrength(SceneSettings settings);

/* Makes or reads a model and validates its cage. warnings: lines on what should be known
 * about it are added. Throws Error, Cancelled. */
Model loadScene(const SceneSettings& settings, std::string& warnings);

} // namespace cbvh
