// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/catalogue.h"
#include "basics/cache_folder.h"
#include "basics/error.h"
#include "basics/input_files.h"
#include "basics/setting_name.h"
#include "scenes/cube.h"
#include "scenes/frog.h"
#include "scenes/herd.h"
#include "scenes/knee.h"
#include "scenes/motion.h"
#include "scenes/scythe.h"
#include "scenes/trex.h"
#include "surface/cage_validation.h"
#include "surface/height_map.h"
#include "surface/mesh.h"
#include "surface/obj_reader.h"
#include "surface/udim_tiles.h"
#include "surface/up_axis.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace cbvh {
namespace {

DisplacementMap mapOf(const SceneSettings& settings, const Cage& cage)
{
  DisplacementMap map;
  map.path = settings.heightPath;
  map.values = settings.mapValues;
  map.midLevel = settings.midLevel;
  map.channel = settings.channel;
  map.repeat = settings.repeat;
  map.scale = settings.mapScale ? *settings.mapScale : *settings.amplitude * cage.bounds().diagonal();
  return map;
}

void chooseUp(Model& model, const SceneSettings& settings, const std::string& path, std::string& warnings)
{
  model.isUpGuessed = settings.up.empty() || settings.up == "auto";
  if (model.isUpGuessed)
  {
    const UpGuess guess = guessUp(model.cage);
    model.up = guess.axis;
    if (!guess.reason.empty())
      warnings += path + ": " + guess.axis + " is taken for up, as " + guess.reason + "; if it is not, give " +
                  settingName("up") + " y\n";
  }
  else
    model.up = settings.up;
  model.view = turnedFromY(model.view, model.up);
}

/* A cage, or a mesh, that no output of the run replaces. */
Cage readInput(const std::string& path, std::string& warnings)
{
  Cage cage = readObj(path, warnings);
  noteInputFile(path);
  return cage;
}

/* The cage's vertices in another file, in the same order. */
std::vector<Vec3f> poseIn(const std::string& path, const Cage& cage, const std::string& cagePath, std::string& warnings)
{
  Cage end = readInput(path, warnings);
  if (end.positions.size() != cage.positions.size() || end.faceIndices != cage.faceIndices)
    throw Error(path + ": " + std::to_string(end.positions.size()) + " vertices and " + std::to_string(end.numFaces()) + " faces are not those of " + cagePath +
                ", which has " + std::to_string(cage.positions.size()) + " and " + std::to_string(cage.numFaces()) + ", in the same order");
  return std::move(end.positions);
}

MotionSettings motionOf(const SceneSettings& settings)
{
  MotionSettings motion;
  motion.name = settings.motion;
  motion.steps = settings.steps.value_or(motion.steps);
  return motion;
}

Model loadCage(const SceneSettings& settings, std::string& warnings)
{
  Model model;
  model.cage = readInput(settings.cagePath, warnings);
  model.name = std::filesystem::path(settings.cagePath).stem().string();
  for (const std::string& path : settings.cageEnds)
    model.poses.push_back(poseIn(path, model.cage, settings.cagePath, warnings));
  validateCage(model.cage, warnings);
  chooseUp(model, settings, settings.cagePath, warnings);
  if (!settings.heightPath.empty())
  {
    model.displacement = displaceByMap(model.cage, mapOf(settings, model.cage), warnings);
    noteMapFiles(model.cage, settings.heightPath);
  }
  return model;
}

Model loadMesh(const SceneSettings& settings, std::string& warnings)
{
  Model model;
  model.isMesh = true;
  model.cage = readInput(settings.meshPath, warnings);
  model.name = std::filesystem::path(settings.meshPath).stem().string();
  makeQuads(model.cage, settings.meshPath);
  model.spacing = latticeSpacing(model.cage.positions);
  chooseUp(model, settings, settings.meshPath, warnings);
  return model;
}

TrexSettings trexSettings(const SceneSettings& s)
{
  TrexSettings trex;
  trex.amplitude = *s.amplitude * (s.rough ? trexRoughFactor : 1.0f);
  trex.mapFolder = s.mapFolder.empty() ? userCacheFolder() : s.mapFolder;
  trex.mapping = s.mapping == "atlas" ? TrexMapping::Atlas : TrexMapping::Faces;
  trex.threads = s.threads;
  return trex;
}

struct SceneEntry
{
  const char* name;
  float amplitude;                     // where none is given
  Model (*make)(const SceneSettings&); // settings that have an amplitude
};

const SceneEntry scenes[] = {
  {"cube", cubeAmplitude, [](const SceneSettings& s) { return makeCube(*s.amplitude); }},
  {"frog", frogAmplitude, [](const SceneSettings& s) { return makeFrog(*s.amplitude, s.threads); }},
  {"herd", trexAmplitude, [](const SceneSettings& s) { return makeHerd(trexSettings(s), s.count.value_or(herdCount)); }},
  {"knee", kneeAmplitude, [](const SceneSettings& s) { return makeKnee(*s.amplitude, s.threads); }},
  {"scythe", scytheAmplitude, [](const SceneSettings& s) { return makeScythe(*s.amplitude, s.threads); }},
  {"trex", trexAmplitude, [](const SceneSettings& s) { return makeTrex(trexSettings(s)); }},
};

/* Null for a name that is unknown. */
const SceneEntry* findScene(const std::string& name)
{
  const auto found = std::find_if(std::begin(scenes), std::end(scenes), [&](const SceneEntry& s) { return name == s.name; });
  return found == std::end(scenes) ? nullptr : found;
}

/* How a map is read. */
void validateMap(const SceneSettings& s)
{
  const std::pair<std::string, bool> given[] = {{settingName("amplitude"), s.amplitude && !s.cagePath.empty()},
                                                {settingName("height-scale"), s.mapScale.has_value()},
                                                {settingName("mid-level"), s.midLevel.has_value()},
                                                {settingName("channel"), !s.channel.empty()},
                                                {settingName("height-repeat"), s.repeat.x != 1.0f || s.repeat.y != 1.0f},
                                                {settingName("vectors"), s.mapValues != MapValues::Heights}};
  for (const auto& [option, isGiven] : given)
    if (isGiven && s.heightPath.empty())
      throw Error(option + " needs a height map, give " + settingName("height") + " FILE");
  if (s.amplitude && s.mapScale)
    throw Error(settingName("amplitude") + " and " + settingName("height-scale") +
                " say the same in different units, give one");
  if (s.mapScale && !std::isfinite(*s.mapScale))
    throw Error(settingName("height-scale") + " must be finite");
  if (s.midLevel && !std::isfinite(*s.midLevel))
    throw Error(settingName("mid-level") + " must be finite");
  if (isUdimPath(s.heightPath) && (s.repeat.x != 1.0f || s.repeat.y != 1.0f))
    throw Error(settingName("height-repeat") + " does not go with <UDIM>, whose tiles are not repeated");
}

} // namespace

const std::vector<std::string>& sceneNames()
{
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const SceneEntry& entry : scenes)
      all.push_back(entry.name);
    return all;
  }();
  return names;
}

std::string listOfScenes()
{
  std::string text;
  const auto& names = sceneNames();
  for (size_t i = 0; i < names.size(); i++)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

void validateScene(const SceneSettings& s)
{
  if (!s.savedPath.empty())
    throw Error(s.savedPath + ": a file of compressed surfaces has no model; cbvh_render and cbvh_viewer show it");
  if (int(!s.scene.empty()) + int(!s.cagePath.empty()) + int(!s.meshPath.empty()) != 1)
    throw Error("give either " + settingName("scene") + " NAME, one of " + listOfScenes() + ", " +
                settingName("cage") + " FILE or " + settingName("mesh") + " FILE");
  if (!s.meshPath.empty() && !s.heightPath.empty())
    throw Error(settingName("height") + " belongs to " + settingName("cage") + ", a mesh is traced as it is");
  if (!s.scene.empty() && !findScene(s.scene))
    throw Error("unknown " + settingName("scene") + " '" + s.scene + "', known are " + listOfScenes());
  if (!s.scene.empty() && !s.heightPath.empty())
    throw Error(settingName("height") + " belongs to " + settingName("cage") +
                ", generated scenes bring their own displacement");
  const bool isTrex = s.scene == "trex" || s.scene == "herd";
  if (s.rough && !isTrex)
    throw Error(settingName("rough") + " belongs to " + settingName("scene") + " trex or herd");
  if (!s.mapping.empty() && !isTrex)
    throw Error(settingName("mapping") + " belongs to " + settingName("scene") + " trex or herd");
  if (!s.mapping.empty() && s.mapping != "faces" && s.mapping != "atlas")
    throw Error("unknown " + settingName("mapping") + " '" + s.mapping + "', known are faces and atlas");
  if (s.count && s.scene != "herd")
    throw Error(settingName("count") + " belongs to " + settingName("scene") + " herd");
  if (s.count && (*s.count < 1 || *s.count > herdMostCount))
    throw Error(settingName("count") + " " + std::to_string(*s.count) + " is out of range, 1 to " +
                std::to_string(herdMostCount));
  if (!s.up.empty() && s.cagePath.empty() && s.meshPath.empty())
    throw Error(settingName("up") + " belongs to " + settingName("cage") + " and " + settingName("mesh"));
  if (s.amplitude && !std::isfinite(*s.amplitude))
    throw Error(settingName("amplitude") + " must be finite");
  if (!s.cageEnds.empty() && s.cagePath.empty())
    throw Error(settingName("cage-end") + " belongs to " + settingName("cage") + ", generated scenes have " +
                settingName("motion"));
  if (!s.cageEnds.empty() && !s.motion.empty())
    throw Error(settingName("cage-end") + " and " + settingName("motion") + " both say how the cage moves, give one");
  if (!s.motion.empty() && !s.meshPath.empty())
    throw Error(settingName("motion") + " belongs to cages and generated scenes");
  if (s.steps && s.motion.empty())
    throw Error(settingName("steps") + " belongs to " + settingName("motion"));
  if (!s.motion.empty())
    validateMotion(motionOf(s));
  validateMap(s);
}

SceneSettings withStrength(SceneSettings s)
{
  if (const SceneEntry* const scene = findScene(s.scene))
    s.amplitude = s.amplitude.value_or(scene->amplitude);
  else if (!s.heightPath.empty() && !s.amplitude && !s.mapScale)
  {
    if (s.mapValues == MapValues::Heights)
      s.amplitude = defaultAmplitude;
    else
      s.mapScale = 1.0f;
  }
  return s;
}

Model loadScene(const SceneSettings& given, std::string& warnings)
{
  validateScene(given);
  const SceneSettings settings = withStrength(given);
  if (!settings.meshPath.empty())
    return loadMesh(settings, warnings);
  Model model;
  if (settings.scene.empty())
    model = loadCage(settings, warnings);
  else
  {
    model = findScene(settings.scene)->make(settings);
    validateCage(model.cage, warnings);
  }
  if (!settings.motion.empty())
    addMotion(model, motionOf(settings));
  return model;
}

} // namespace cbvh
