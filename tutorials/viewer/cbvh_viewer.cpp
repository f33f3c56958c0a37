// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Shows a displaced subdivision surface in any representation. See --help. */

#include "options.h"
#include "view_state.h"
#include "window.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "pictures/image_output.h"
#include "programs/view_options.h"
#include "programs/warnings.h"

#include <cstdio>
#include <new>

namespace cbvh {
namespace {

/* Both views are fitted to GRID. A coarse one is quick to build and does. */
Camera startCamera(const ViewerOptions& options, const Model& model)
{
  constexpr int coarse = 3;
  BuildSettings settings = options.build;
  settings.level = std::min(settings.level, coarse);
  const BuiltScene grid(model, {RepresentationKind::Grid}, settings);
  if (grid.report().quads == 0 || !isFinite(grid.bounds().lower) || !isFinite(grid.bounds().upper))
    throw Error(model.name + ": Embree makes no surface of this cage");
  return chooseCamera(options.view, model, grid, options.size, threadCount(options.build.threads));
}

void writeScreenshot(const ViewerOptions& options, const Model& model, SceneStore& store, const Camera& camera)
{
  const ViewState state{options.representations, options.build.level, options.mode};
  store.request(state.scenes());
  store.finish();
  std::vector<PaneReport> reports;
  PictureSettings settings;
  settings.mode = options.mode;
  settings.up = model.view.up;
  settings.threads = threadCount(options.build.threads);
  writePng(options.screenshot, renderPicture(camera, findPanes(state, store), settings, reports));
}

int run(int argc, char** argv)
{
  const std::optional<ViewerOptions> options = parseViewerOptions(argc, argv);
  if (!options)
    return 0;
  installCancelHandler();
  std::string warnings;
  const Model model = loadScene(options->scene, warnings);
  printWarnings("cbvh_viewer", warnings);
  const Camera camera = startCamera(*options, model);
  SceneStore store(model, options->build);
  if (options->screenshot.empty())
    showWindow(*options, model, store, camera);
  else
    writeScreenshot(*options, model, store, camera);
  return 0;
}

} // namespace
} // namespace cbvh

int main(int argc, char** argv)
{
  try
  {
    return cbvh::run(argc, argv);
  }
  catch (const cbvh::Cancelled&)
  {
    std::fprintf(stderr, "cbvh_viewer: cancelled\n");
    return 130;
  }
  catch (const std::bad_alloc&)
  {
    std::fprintf(stderr, "cbvh_viewer: out of memory\n");
  }
  catch (const std::exception& e)
  {
    std::fprintf(stderr, "cbvh_viewer: %s\n", e.what());
  }
  return 1;
}
