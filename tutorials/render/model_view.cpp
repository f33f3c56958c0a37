// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "model_view.h"

#include "basics/parallel.h"
#include "building/view_dicing.h"
#include "programs/program_scene.h"
#include "programs/view_options.h"

namespace cbvh {
namespace {

/* The same for every representation and alone: fitted to a GRID, which is dropped, of as
 * fine a level as is made in no time. */
Camera cameraOf(const Options& options, const Model& model, unsigned threads)
{
  constexpr size_t mostQuads = 4000000;
  BuildSettings coarse = options.build;
  if (model.isMesh)
    coarse.level = 0; // it has no others
  while (coarse.level > 0 && model.layout(coarse.level).numQuads() > mostQuads)
    coarse.level--;
  coarse.device = "cpu";
  coarse.name = "view";
  return chooseCamera(options.view, model, BuiltScene(model, {RepresentationKind::Grid}, coarse), options.size, threads);
}

/* Of the whole picture, whatever part of it is rendered. */
BuildSettings settingsFor(const Options& options, const Model& model, const Camera& camera)
{
  std::optional<ViewDicing> dicing;
  if (options.autoLevel)
    dicing = ViewDicing{options.quadSize, highestRate(options.representations)};
  return settingsForView(options.build, model, camera, dicing, options.maxPixelError);
}

} // namespace

ModelView::ModelView(const Options& options)
  : model(loadProgramScene("cbvh_render", options.scene)), camera(cameraOf(options, model, threadCount(options.build.threads))), build(settingsFor(options, model, camera))
{
}

} // namespace cbvh
