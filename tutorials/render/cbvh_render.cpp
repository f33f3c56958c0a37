// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "comparison.h"
#include "options.h"
#include "report.h"
#include "saved_scene_picture.h"
#include "basics/file_output.h"
#include "basics/progress.h"
#include "programs/outputs.h"
#include "programs/run_program.h"

namespace {

int run(int argc, char** argv) {
  const std::optional<cbvh::Options> options = cbvh::parseOptions(argc, argv);
  if (!options) return 0;
  cbvh::installCancelHandler();
  cbvh::forceExitAfterCancel("cbvh_render");
  cbvh::prepareOutputFolder(options->output);
  cbvh::requireWritable({{"--save", options->savePath}, {"--export", options->exportPath}, {"--json", options->json}});
  if (!options->loadPath.empty()) {
    cbvh::renderSavedScene(*options);
    return 0;
  }
  const cbvh::ModelView view(*options);
  if (options->savesCopyByCopy()) {
    cbvh::saveAndRender(*options, view);
    return 0;
  }
  const cbvh::Comparison comparison = cbvh::runComparison(*options, view);
  cbvh::writeStandardOutput(cbvh::formatTable(comparison, options->details));
  if (!options->json.empty()) cbvh::writeTextFile(options->json, cbvh::formatJson(comparison));
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  return cbvh::runProgram("cbvh_render", [=] { return run(argc, argv); });
}
