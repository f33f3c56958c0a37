// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "document.h"
#include "basics/parallel.h"
#include "programs/view_options.h"

namespace cbvh {
namespace {

/* A level that is built in well under a second. */
int coarseLevel(const Model& model, int level)
{
  constexpr int coarse = 3;
  constexpr size_t quads = 1 << 20;
  level = std::min(level, coarse);
  while (level > 1 && model.layout(level).numQuads() > quads)
    level--;
  return level;
}

} // namespace

std::unique_ptr<const LoadedModel> loadModel(const SceneSettings& source, const ViewerOptions& options)
{
  auto loaded = std::make_unique<LoadedModel>();
  loaded->source = withStrength(source);
  loaded->model = loadScene(loaded->source, loaded->warnings);
  BuildSettings settings = options.build;
  settings.level = coarseLevel(loaded->model, settings.level); // whatever the view
  settings.device = "cpu";
  loaded->preview = std::make_unique<BuiltScene>(loaded->model, Representation{RepresentationKind::Grid}, settings);
  loaded->start = chooseCamera(options.view, loaded->model, *loaded->preview, options.size,
                               threadCount(options.build.threads));
  return loaded;
}

} // namespace cbvh
