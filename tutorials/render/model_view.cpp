// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "model_view.h"

#include "basics/parallel.h"
#include "building/view_dicing.h"
#include "programs/program_scene.h"
#include "programs/view_options.h"

namespace programs {
namespace {

/* The same for every representation: fitted to a GRID at a level that is fast to build. */
Camera cameraOf(const Options& options, const Model& model, unsigned threads) {
  constexpr size_t maxQuads = 4000000;
  BuildSettings coarse = options.build;
  if (model.isMesh) coarse.level = 0; // meshes have no other levels
  while (coarse.level > 0 && model.layout(coarse.level).numQuads() > maxQuads) coarse.level--;
  coarse.device = "cpu";
  coarse.name = "view";
  const BuiltScene grid(model, {RepresentationKind::Grid}, coarse);
  return chooseCamera(options.view, model, grid, options.size, threads);
}

/* For the whole picture, even if only a part is rendered. */
BuildSettings settingsFor(const Options& options, const Model& model, const Camera& camera) {
  std::optional<ViewDicing> dicing;
  if (options.autoLevel) dicing = ViewDicing{options.quadSize, highestRate(options.representations)};
  return settingsForView(options.build, model, camera, dicing, options.maxPixelError);
}

} // namespace

ModelView::ModelView(const Options& options)
  : model(loadProgramScene("cbvh_render", options.scene)),
    camera(cameraOf(options, model, threadCount(options.build.threads))),
    build(settingsFor(options, model, camera)) {}

} // namespace programs
