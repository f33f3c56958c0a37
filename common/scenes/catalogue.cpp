// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/catalogue.h"
#include "basics/cache_folder.h"
#include "basics/error.h"
#include "basics/input_files.h"
#include "basics/setting_name.h"
#include "basics/text.h"
#include "meshes/mesh_file.h"
#include "meshes/polygon_triangles.h"
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

namespace programs {
namespace {

DisplacementMap mapOf(const SceneSettings& settings, const Cage& cage) {
  DisplacementMap map;
  map.path = settings.heightPath;
  map.values = settings.mapValues;
  map.midLevel = settings.midLevel;
  map.channel = settings.channel;
  map.repeat = settings.repeat;
  map.wrap = settings.wrap;
  map.scale = settings.mapScale ? *settings.mapScale : *settings.amplitude * cage.bounds().diagonal();
  return map;
}

void chooseUp(Model& model, const SceneSettings& settings, const std::string& path, std::string& warnings) {
  model.isUpGuessed = settings.up.empty() || settings.up == "auto";
  if (model.isUpGuessed) {
    const UpGuess guess = guessUp(model.cage);
    model.up = guess.axis;
    if (!guess.reason.empty())
      warnings += path + ": " + guess.axis + " is assumed to be the up axis, because " + guess.reason + "; " +
                  settingName("up") + " y selects y\n";
  } else model.up = settings.up;
  model.view = rotatedFromY(model.view, model.up);
}

/* Records the file as an input of the run. */
Cage readInput(const std::string& path, std::string& warnings) {
  Cage cage = readObj(path, warnings);
  recordInputFile(path);
  return cage;
}

std::vector<Vec3f> readPose(const std::string& path, const Cage& cage, const std::string& cagePath,
                            std::string& warnings) {
  Cage end = readInput(path, warnings);
  if (end.positions.size() != cage.positions.size() || end.faceIndices != cage.faceIndices)
    throw Error(path + ": the file has " + std::to_string(end.positions.size()) + " vertices and " +
                std::to_string(end.numFaces()) + " faces: expected the faces of " + cagePath + ", which has " +
                std::to_string(cage.positions.size()) + " and " + std::to_string(cage.numFaces()) +
                ", in the same order");
  return std::move(end.positions);
}

MotionSettings motionOf(const SceneSettings& settings) {
  MotionSettings motion;
  motion.name = settings.motion;
  motion.steps = settings.steps.value_or(motion.steps);
  return motion;
}

Model loadCage(const SceneSettings& settings, std::string& warnings) {
  Model model;
  model.cage = readInput(settings.cagePath, warnings);
  model.name = std::filesystem::path(settings.cagePath).stem().string();
  for (const std::string& path : settings.cageEnds)
    model.poses.push_back(readPose(path, model.cage, settings.cagePath, warnings));
  validateCage(model.cage, warnings);
  chooseUp(model, settings, settings.cagePath, warnings);
  if (!settings.heightPath.empty()) {
    model.displacement = displaceByMap(model.cage, mapOf(settings, model.cage), warnings);
    recordMapFiles(model.cage, settings.heightPath);
  }
  return model;
}

/* Faces of 4 vertices; triangles repeat the last one. The mesh loses its faces and positions. */
Cage cageOf(PolygonMesh& mesh, const std::string& path, std::string& warnings) {
  Cage cage;
  cage.name = path;
  cage.comments = mesh.comments;
  cage.positions = roundedPositions(mesh, path, warnings);
  MeshPrimitives primitives = splitPolygons(mesh);
  mesh.positions = {};
  cage.faceSizes.assign(primitives.size(), 4);
  if (primitives.corners == 4) cage.faceIndices = std::move(primitives.indices);
  else {
    cage.faceIndices.reserve(4 * primitives.size());
    for (size_t i = 0; i < primitives.indices.size(); i += 3) {
      const unsigned* const v = &primitives.indices[i];
      cage.faceIndices.insert(cage.faceIndices.end(), {v[0], v[1], v[2], v[2]});
    }
  }
  return cage;
}

Model loadMesh(const SceneSettings& settings, std::string& warnings) {
  Model model;
  model.isMesh = true;
  const std::string& path = settings.meshPath;
  PolygonMesh mesh = readMesh(path, warnings);
  model.cage = cageOf(mesh, path, warnings);
  model.name = std::filesystem::path(path).stem().string();
  model.spacing = latticeSpacing(model.cage.positions);
  if (mesh.up.empty()) chooseUp(model, settings, path, warnings);
  else {
    const bool isChosen = !settings.up.empty() && settings.up != "auto";
    model.up = isChosen ? settings.up : mesh.up;
    model.view = rotatedFromY(model.view, model.up);
  }
  return model;
}

TrexSettings trexSettings(const SceneSettings& s) {
  TrexSettings trex;
  trex.amplitude = *s.amplitude * (s.rough ? trexRoughFactor : 1.0f);
  trex.mapFolder = s.mapFolder.empty() ? userCacheFolder() : s.mapFolder;
  trex.mapping = s.mapping == "atlas" ? TrexMapping::Atlas : TrexMapping::Faces;
  trex.threads = s.threads;
  return trex;
}

struct SceneEntry {
  const char* name;
  float amplitude;                     // default
  Model (*make)(const SceneSettings&); // requires an amplitude
};

const SceneEntry scenes[] = {
    {"cube", cubeAmplitude, [](const SceneSettings& s) { return makeCube(*s.amplitude); }},
    {"frog", frogAmplitude, [](const SceneSettings& s) { return makeFrog(*s.amplitude, s.threads); }},
    {"herd", trexAmplitude,
     [](const SceneSettings& s) { return makeHerd(trexSettings(s), s.count.value_or(herdCount)); }},
    {"knee", kneeAmplitude, [](const SceneSettings& s) { return makeKnee(*s.amplitude, s.threads); }},
    {"scythe", scytheAmplitude, [](const SceneSettings& s) { return makeScythe(*s.amplitude, s.threads); }},
    {"trex", trexAmplitude, [](const SceneSettings& s) { return makeTrex(trexSettings(s)); }},
};

const SceneEntry* findScene(const std::string& name) {
  const auto found =
      std::find_if(std::begin(scenes), std::end(scenes), [&](const SceneEntry& s) { return name == s.name; });
  return found == std::end(scenes) ? nullptr : found;
}

void validateMap(const SceneSettings& s) {
  const bool isRepeated = s.repeat.x != 1.0f || s.repeat.y != 1.0f;
  const std::pair<std::string, bool> mapOptions[] = {{settingName("amplitude"), s.amplitude && !s.cagePath.empty()},
                                                     {settingName("height-scale"), s.mapScale.has_value()},
                                                     {settingName("mid-level"), s.midLevel.has_value()},
                                                     {settingName("channel"), !s.channel.empty()},
                                                     {settingName("height-repeat"), isRepeated},
                                                     {settingName("height-wrap"), s.wrap.has_value()},
                                                     {settingName("vectors"), s.mapValues != MapValues::Heights}};
  for (const auto& [option, isSet] : mapOptions)
    if (isSet && s.heightPath.empty())
      throw Error(option + " needs a height map: expected " + settingName("height") + " FILE");
  if (s.amplitude && s.mapScale)
    throw Error(settingName("amplitude") + " and " + settingName("height-scale") +
                " both set the scale of the map: expected one of them");
  if (s.mapScale && !std::isfinite(*s.mapScale))
    throw Error(settingName("height-scale") + " is not finite: expected a finite number");
  if (s.midLevel && !std::isfinite(*s.midLevel))
    throw Error(settingName("mid-level") + " is not finite: expected a finite number");
  if (isUdimPath(s.heightPath) && isRepeated)
    throw Error(settingName("height-repeat") + " cannot repeat the tiles of " + s.heightPath + ": expected 1");
}

} // namespace

void validateScale(const std::optional<float>& amplitude, const std::optional<float>& mapScale,
                   const std::optional<float>& midLevel, const Cage& cage) {
  const float largest = 1e17f; // Embree's limit is 1.8e18; heights and --rough can exceed the scale several times
  const float scale = mapScale ? *mapScale : amplitude.value_or(0.0f);
  const float unit = mapScale ? 1.0f : cage.bounds().diagonal();
  if (unit > largest) return;
  if (!(std::fabs(scale) * unit <= largest))
    throw Error(settingName(mapScale ? "height-scale" : "amplitude") + " " + shortNumber(scale) +
                " is too large: expected at most " + shortNumber(largest / unit) + " for this cage");
  const float highest = largest / (std::fabs(scale) * unit);
  if (midLevel && std::fabs(*midLevel) > highest)
    throw Error(settingName("mid-level") + " " + shortNumber(*midLevel) + " is too large: expected at most " +
                shortNumber(highest) + " for this cage and scale");
}

const std::vector<std::string>& sceneNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const SceneEntry& entry : scenes) all.push_back(entry.name);
    return all;
  }();
  return names;
}

std::string listOfScenes(const std::string& last) {
  std::string text;
  const auto& names = sceneNames();
  for (size_t i = 0; i < names.size(); i++) text += (i == 0 ? "" : i + 1 == names.size() ? last : ", ") + names[i];
  return text;
}

void validateScene(const SceneSettings& s) {
  if (!s.savedPath.empty())
    throw Error(s.savedPath + ": a file of compressed surfaces contains no model: expected a cage, or use cbvh_render "
                              "or cbvh_viewer, which show such files");
  if (int(!s.scene.empty()) + int(!s.cagePath.empty()) + int(!s.meshPath.empty()) != 1)
    throw Error("expected one of " + settingName("scene") + " NAME (" + listOfScenes(" or ") + "), " +
                settingName("cage") + " FILE and " + settingName("mesh") + " FILE");
  if (!s.meshPath.empty() && !s.heightPath.empty())
    throw Error(settingName("height") + " needs " + settingName("cage") + ": meshes are not displaced");
  if (!s.scene.empty() && !findScene(s.scene))
    throw Error("unknown " + settingName("scene") + " '" + s.scene + "': expected " + listOfScenes(" or "));
  if (!s.scene.empty() && !s.heightPath.empty())
    throw Error(settingName("height") + " needs " + settingName("cage") +
                ": generated scenes have their own displacement");
  const bool isTrex = s.scene == "trex" || s.scene == "herd";
  if (s.rough && !isTrex) throw Error(settingName("rough") + " needs " + settingName("scene") + " trex or herd");
  if (!s.mapping.empty() && !isTrex)
    throw Error(settingName("mapping") + " needs " + settingName("scene") + " trex or herd");
  if (!s.mapping.empty() && s.mapping != "faces" && s.mapping != "atlas")
    throw Error("unknown " + settingName("mapping") + " '" + s.mapping + "': expected faces or atlas");
  if (s.count && s.scene != "herd") throw Error(settingName("count") + " needs " + settingName("scene") + " herd");
  if (s.count && (*s.count < 1 || *s.count > maxHerdCount))
    throw Error(settingName("count") + " " + std::to_string(*s.count) + " is out of range: expected 1 to " +
                std::to_string(maxHerdCount));
  if (!s.up.empty() && s.cagePath.empty() && s.meshPath.empty())
    throw Error(settingName("up") + " needs " + settingName("cage") + " or " + settingName("mesh"));
  if (s.amplitude && !std::isfinite(*s.amplitude))
    throw Error(settingName("amplitude") + " is not finite: expected a finite number");
  if (!s.cageEnds.empty() && s.cagePath.empty())
    throw Error(settingName("cage-end") + " needs " + settingName("cage") + ": expected " + settingName("motion") +
                " for generated scenes");
  if (!s.cageEnds.empty() && !s.motion.empty())
    throw Error(settingName("cage-end") + " and " + settingName("motion") +
                " both set the motion: expected one of them");
  if (!s.motion.empty() && !s.meshPath.empty())
    throw Error(settingName("motion") + " needs a cage or a generated scene: meshes do not move");
  if (s.steps && s.motion.empty()) throw Error(settingName("steps") + " needs " + settingName("motion"));
  if (!s.motion.empty()) validateMotion(motionOf(s));
  validateMap(s);
}

SceneSettings withDefaultAmplitude(SceneSettings s) {
  if (const SceneEntry* const scene = findScene(s.scene)) s.amplitude = s.amplitude.value_or(scene->amplitude);
  else if (!s.heightPath.empty() && !s.amplitude && !s.mapScale) {
    if (s.mapValues == MapValues::Heights) s.amplitude = defaultAmplitude;
    else s.mapScale = 1.0f;
  }
  return s;
}

Model loadScene(const SceneSettings& given, std::string& warnings) {
  validateScene(given);
  const SceneSettings settings = withDefaultAmplitude(given);
  if (!settings.meshPath.empty()) return loadMesh(settings, warnings);
  Model model;
  if (settings.scene.empty()) model = loadCage(settings, warnings);
  else {
    model = findScene(settings.scene)->make(settings);
    validateCage(model.cage, warnings);
  }
  validateScale(settings.amplitude, settings.mapScale, settings.midLevel, model.cage);
  if (!settings.motion.empty()) addMotion(model, motionOf(settings));
  return model;
}

} // namespace programs
