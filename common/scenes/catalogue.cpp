// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/catalogue.h"
#include "basics/cache_folder.h"
#include "basics/error.h"
#include "scenes/cube.h"
#include "scenes/frog.h"
#include "scenes/herd.h"
#include "scenes/knee.h"
#include "scenes/scythe.h"
#include "scenes/trex.h"
#include "surface/cage_validation.h"
#include "surface/height_map.h"
#include "surface/obj_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace cbvh {
namespace {

Model loadCage(const SceneSettings& settings, std::string& warning)
{
  constexpr float defaultAmplitude = 0.006f;
  Model model;
  model.cage = readObj(settings.cagePath);
  model.name = std::filesystem::path(settings.cagePath).stem().string();
  if (settings.heightPath.empty())
    return model;
  const float scale = settings.amplitude.value_or(defaultAmplitude) * model.cage.bounds().diagonal();
  if (model.cage.hasUVs())
    model.displacement = displaceByUVs(model.cage, settings.heightPath, scale);
  else
    model.displacement = displaceByFace(model.cage, settings.heightPath, scale, warning);
  return model;
}

TrexSettings trexSettings(const SceneSettings& s)
{
  TrexSettings trex;
  trex.amplitude = s.amplitude.value_or(trex.amplitude) * (s.rough ? trexRoughFactor : 1.0f);
  trex.mapFolder = s.mapFolder.empty() ? userCacheFolder() : s.mapFolder;
  trex.mapping = s.mapping == "atlas" ? TrexMapping::Atlas : TrexMapping::Faces;
  trex.threads = s.threads;
  return trex;
}

struct SceneEntry
{
  const char* name;
  Model (*make)(const SceneSettings&);
};

const SceneEntry scenes[] = {
  {"cube", [](const SceneSettings& s) { return makeCube(s.amplitude.value_or(cubeAmplitude)); }},
  {"frog", [](const SceneSettings& s) { return makeFrog(s.amplitude.value_or(frogAmplitude), s.threads); }},
  {"herd", [](const SceneSettings& s) { return makeHerd(trexSettings(s), s.count.value_or(herdCount)); }},
  {"knee", [](const SceneSettings& s) { return makeKnee(s.amplitude.value_or(kneeAmplitude), s.threads); }},
  {"scythe", [](const SceneSettings& s) { return makeScythe(s.amplitude.value_or(scytheAmplitude), s.threads); }},
  {"trex", [](const SceneSettings& s) { return makeTrex(trexSettings(s)); }},
};

Model makeScene(const SceneSettings& s)
{
  for (const SceneEntry& entry : scenes)
    if (s.scene == entry.name)
      return entry.make(s);
  throw Error("unknown --scene '" + s.scene + "', known are " + listOfScenes());
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
  if (s.scene.empty() == s.cagePath.empty())
    throw Error("give either --scene NAME, one of " + listOfScenes() + ", or --cage FILE");
  if (!s.scene.empty() && std::find(sceneNames().begin(), sceneNames().end(), s.scene) == sceneNames().end())
    throw Error("unknown --scene '" + s.scene + "', known are " + listOfScenes());
  if (!s.scene.empty() && !s.heightPath.empty())
    throw Error("--height belongs to --cage, generated scenes bring their own displacement");
  const bool isTrex = s.scene == "trex" || s.scene == "herd";
  if (s.rough && !isTrex)
    throw Error("--rough belongs to --scene trex or herd");
  if (!s.mapping.empty() && !isTrex)
    throw Error("--mapping belongs to --scene trex or herd");
  if (!s.mapping.empty() && s.mapping != "faces" && s.mapping != "atlas")
    throw Error("unknown --mapping '" + s.mapping + "', known are faces and atlas");
  if (s.count && s.scene != "herd")
    throw Error("--count belongs to --scene herd");
  if (s.count && (*s.count < 1 || *s.count > herdMostCount))
    throw Error("--count " + std::to_string(*s.count) + " is out of range, 1 to " + std::to_string(herdMostCount));
  if (s.amplitude && !s.cagePath.empty() && s.heightPath.empty())
    throw Error("--amplitude needs a height map, give --height FILE");
  if (s.amplitude && !std::isfinite(*s.amplitude))
    throw Error("--amplitude must be finite");
}

Model loadScene(const SceneSettings& settings, std::string& warning)
{
  validateScene(settings);
  Model model = settings.scene.empty() ? loadCage(settings, warning) : makeScene(settings);
  validateCage(model.cage);
  return model;
}

} // namespace cbvh
