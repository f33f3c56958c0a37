// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/opened_files.h"
#include "basics/error.h"
#include "basics/text.h"

#include <filesystem>

namespace cbvh {
namespace {

bool isCage(const std::string& path)
{
  return lowerCase(std::filesystem::path(path).extension().string()) == ".obj";
}

/* How a map was read that is gone, or how strong a generated scene was. */
void forgetMap(SceneSettings& settings)
{
  const SceneSettings fresh;
  settings.mapValues = fresh.mapValues;
  settings.midLevel = fresh.midLevel;
  settings.channel = fresh.channel;
  settings.repeat = fresh.repeat;
  settings.mapScale = fresh.mapScale;
  settings.amplitude = fresh.amplitude;
}

} // namespace

SceneSettings openFiles(const std::vector<std::string>& paths, const SceneSettings& current)
{
  std::string cage, height;
  for (const std::string& path : paths)
  {
    std::string& place = isCage(path) ? cage : height;
    if (!place.empty())
      throw Error(place + " and " + path + ": only one " + (isCage(path) ? "cage" : "height map") + " can be opened at a time");
    place = path;
  }
  SceneSettings opened = current;
  if (!cage.empty())
  {
    opened.cagePath = cage;
    opened.meshPath.clear();
    opened.scene.clear();
    opened.rough = false;
    opened.mapping.clear();
    opened.count.reset();
    if (height.empty() || !current.scene.empty())
      forgetMap(opened);
  }
  else if (current.cagePath.empty())
    throw Error(height + ": a height map needs a cage, open an OBJ first" +
                (current.scene.empty() ? "" : "; " + current.scene + " brings its own heights"));
  opened.heightPath = height;
  return opened;
}

void nameFiles(const std::vector<std::string>& files, SceneSettings& scene)
{
  SceneSettings named;
  named.cagePath = scene.cagePath; // a height map alone goes on it
  if (!files.empty())
    named = openFiles(files, named);
  if (named.cagePath != scene.cagePath && !(scene.scene.empty() && scene.cagePath.empty()))
    throw Error(named.cagePath + ": there is a --scene or a --cage already");
  if (!named.heightPath.empty() && !scene.heightPath.empty())
    throw Error(named.heightPath + ": there is a --height already");
  scene.cagePath = named.cagePath;
  if (!named.heightPath.empty())
    scene.heightPath = named.heightPath;
}

} // namespace cbvh
