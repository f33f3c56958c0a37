// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "document.h"
#include "basics/parallel.h"
#include "programs/view_options.h"

#include <algorithm>
#include <filesystem>

namespace programs {
namespace {

/* Builds in much less than a second. */
int coarseLevel(const Model& model, int level) {
  constexpr int coarse = 3;
  constexpr size_t quads = 1 << 20;
  level = std::min(level, coarse);
  while (level > 1 && model.layout(level).numQuads() > quads) level--;
  return level;
}

std::unique_ptr<const LoadedModel> openSaved(const SceneSettings& source, const ViewerOptions& options) {
  auto loaded = std::make_unique<LoadedModel>();
  loaded->source = source;
  const unsigned threads = threadCount(options.build.threads);
  loaded->saved = std::make_unique<SavedScene>(source.savedPath, threads, options.build.isa);
  const std::string name = std::filesystem::path(source.savedPath).stem().string();
  loaded->model = boxModel(name, loaded->saved->bounds(), source.up);
  loaded->start = chooseCamera(options.view, loaded->model, *loaded->saved, options.size, threads);
  return loaded;
}

} // namespace

bool LoadedModel::moves() const {
  if (!saved) return !model.poses.empty();
  const auto moves = [](const CbvhFileSurfaceInfo& g) { return g.numTimeSteps > 1; };
  return std::any_of(saved->geometries().begin(), saved->geometries().end(), moves);
}

std::unique_ptr<const LoadedModel> loadModel(const SceneSettings& source, const ViewerOptions& options) {
  if (!source.savedPath.empty()) return openSaved(source, options);
  auto loaded = std::make_unique<LoadedModel>();
  loaded->source = withDefaultAmplitude(source);
  loaded->model = loadScene(loaded->source, loaded->warnings);
  BuildSettings settings = options.build;
  settings.level = coarseLevel(loaded->model, settings.level); // independent of the view
  settings.device = "cpu";
  loaded->preview = std::make_unique<BuiltScene>(loaded->model, Representation{RepresentationKind::Grid}, settings);
  loaded->start =
      chooseCamera(options.view, loaded->model, *loaded->preview, options.size, threadCount(options.build.threads));
  return loaded;
}

} // namespace programs
