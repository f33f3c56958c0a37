// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/opened_files.h"
#include "basics/error.h"
#include "basics/pipe_input.h"
#include "basics/text.h"

#include <filesystem>

namespace cbvh {
namespace {

bool endsIn(const char* extension, const std::string& path)
{
  return lowerCase(std::filesystem::path(path).extension().string()) == extension;
}

/* A pipe has no extension of use, and maps are never read from pipes. */
bool isCage(const std::string& path) { return endsIn(".obj", path) || isPipe(path); }
bool isSavedScene(const std::string& path) { return endsIn(".cbvh", path); }

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
    if (isSavedScene(path))
    {
      if (paths.size() > 1)
        throw Error(path + ": a file of compressed surfaces is opened alone");
      SceneSettings saved;
      saved.savedPath = path;
      saved.threads = current.threads;
      return saved;
    }
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
    opened.savedPath.clear();
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
  if (!named.savedPath.empty() && !(scene.scene.empty() && scene.cagePath.empty() && scene.meshPath.empty() && scene.heightPath.empty()))
    throw Error(named.savedPath + ": a file of compressed surfaces is opened without a model");
  scene.savedPath = named.savedPath;
  if (named.cagePath != scene.cagePath && !(scene.scene.empty() && scene.cagePath.empty()))
    throw Error(named.cagePath + ": there is a --scene or a --cage already");
  if (!named.heightPath.empty() && !scene.heightPath.empty())
    throw Error(named.heightPath + ": there is a --height already");
  if (named.savedPath.empty())
    scene.cagePath = named.cagePath;
  if (!named.heightPath.empty())
    scene.heightPath = named.heightPath;
}

} // namespace cbvh
