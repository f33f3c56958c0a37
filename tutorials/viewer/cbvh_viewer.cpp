// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "document.h"
#include "view_state.h"
#include "window.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "pictures/image_output.h"
#include "programs/run_program.h"
#include "programs/warnings.h"

namespace programs { namespace {

void writeOutput(const ViewerOptions& options) {
  Worker worker;
  Document document(loadModel(options.scene, options), options, worker);
  printWarnings("cbvh_viewer", document.loaded->warnings + motionWarnings(document.model(), options.representations));
  const int level = options.autoLevel ? autoLevel : options.build.level;
  ViewState state{options.representations, level, options.mode, std::nullopt};
  if (options.autoLevel && !document.model().isMesh) state.camera = document.loaded->start;
  if (!document.loaded->saved) document.store.request(state.scenes());
  document.store.finish();
  printWarnings("cbvh_viewer", seamWarnings(document.model(), document.store.largestSeamGap()));
  PictureSettings settings;
  settings.mode = options.mode;
  settings.up = document.model().view.up;
  settings.threads = threadCount(options.build.threads);
  settings.samples = options.samples;
  settings.time = options.time;
  const Image image = renderPicture(*document.loaded->start, findPanes(state, document), settings);
  if (document.loaded->saved) document.loaded->saved->check();
  writePng(options.output, image);
}

int run(int argc, char** argv) {
  const std::optional<ViewerOptions> options = parseViewerOptions(argc, argv);
  if (!options) return 0;
  installCancelHandler();
  if (options->noWindow) writeOutput(*options);
  else showWindow(*options);
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_viewer", [=] { return programs::run(argc, argv); });
}
