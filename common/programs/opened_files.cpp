// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/opened_files.h"
#include "basics/error.h"
#include "basics/pipe_input.h"
#include "basics/text.h"
#include "meshes/mesh_file.h"

#include <filesystem>

namespace programs {
namespace {

bool hasExtension(const char* extension, const std::string& path) {
  return lowerCase(std::filesystem::path(path).extension().string()) == extension;
}

/* Pipes are cages, because maps cannot be read from pipes. */
bool isCage(const std::string& path) { return hasExtension(".obj", path) || isPipe(path); }
bool isSavedScene(const std::string& path) { return hasExtension(".cbvh", path); }

bool isMesh(const std::string& path) {
  return isMeshExtension(lowerCase(std::filesystem::path(path).extension().string()));
}

void resetMap(SceneSettings& settings) {
  const SceneSettings fresh;
  settings.mapValues = fresh.mapValues;
  settings.midLevel = fresh.midLevel;
  settings.channel = fresh.channel;
  settings.repeat = fresh.repeat;
  settings.mapScale = fresh.mapScale;
  settings.amplitude = fresh.amplitude;
}

} // namespace

SceneSettings openFiles(const std::vector<std::string>& paths, const SceneSettings& current) {
  std::string cage, height;
  for (const std::string& path : paths) {
    if (isSavedScene(path) || isMesh(path)) {
      if (paths.size() > 1)
        throw Error(path + ": a file of " + (isMesh(path) ? "a mesh" : "compressed surfaces") +
                    " must be opened alone: expected one file");
      SceneSettings alone;
      (isMesh(path) ? alone.meshPath : alone.savedPath) = path;
      alone.threads = current.threads;
      return alone;
    }
    std::string& slot = isCage(path) ? cage : height;
    if (!slot.empty())
      throw Error(slot + " and " + path + ": expected only one " + (isCage(path) ? "cage" : "height map"));
    slot = path;
  }
  SceneSettings opened = current;
  if (!cage.empty()) {
    opened.cagePath = cage;
    opened.meshPath.clear();
    opened.savedPath.clear();
    opened.scene.clear();
    opened.rough = false;
    opened.mapping.clear();
    opened.count.reset();
    opened.cageEnds.clear();
    if (height.empty() || !current.scene.empty()) resetMap(opened);
  } else if (current.cagePath.empty())
    throw Error(height + ": a height map needs a cage: expected an OBJ first" +
                (current.scene.empty() ? "" : "; " + current.scene + " has its own heights"));
  opened.heightPath = height;
  return opened;
}

void applyFileArguments(const std::vector<std::string>& files, SceneSettings& scene) {
  SceneSettings named;
  named.cagePath = scene.cagePath; // a height map alone belongs to this cage
  if (!files.empty()) named = openFiles(files, named);
  const bool hasModel =
      !scene.scene.empty() || !scene.cagePath.empty() || !scene.meshPath.empty() || !scene.heightPath.empty();
  const std::string alone = named.savedPath + named.meshPath; // one of them is empty
  if (!alone.empty() && hasModel)
    throw Error(alone + ": a file of " + (named.savedPath.empty() ? "a mesh" : "compressed surfaces") +
                " must be opened alone: expected no model options");
  scene.savedPath = named.savedPath;
  if (!named.meshPath.empty()) scene.meshPath = named.meshPath;
  if (named.cagePath != scene.cagePath && !(scene.scene.empty() && scene.cagePath.empty()))
    throw Error(named.cagePath + ": --scene or --cage names another model: expected only one");
  if (!named.heightPath.empty() && !scene.heightPath.empty())
    throw Error(named.heightPath + ": --height names another height map: expected only one");
  if (named.savedPath.empty()) scene.cagePath = named.cagePath;
  if (!named.heightPath.empty()) scene.heightPath = named.heightPath;
}

} // namespace programs
