// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "catalogue.h"
#include "cube.h"
#include "trex.h"

#include "../cage_validation.h"
#include "../error.h"
#include "../height_map.h"
#include "../obj_reader.h"

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

Model makeScene(const SceneSettings& s)
{
  if (s.scene == "cube")
    return makeCube(s.amplitude.value_or(cubeAmplitude));
  TrexSettings trex;
  trex.amplitude = s.amplitude.value_or(trex.amplitude) * (s.rough ? trexRoughFactor : 1.0f);
  trex.mapPath = (std::filesystem::path(s.mapFolder) / "trex_height.exr").string();
  trex.threads = s.threads;
  return makeTrex(trex);
}

} // namespace

const std::vector<std::string>& sceneNames()
{
  static const std::vector<std::string> names{"cube", "trex"};
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
  if (s.rough && s.scene != "trex")
    throw Error("--rough belongs to --scene trex");
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
