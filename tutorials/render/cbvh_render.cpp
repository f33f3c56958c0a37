// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "comparison.h"
#include "options.h"
#include "report.h"
#include "saved_scene_picture.h"
#include "basics/file_output.h"
#include "basics/progress.h"
#include "pictures/joined_picture.h"
#include "programs/outputs.h"
#include "programs/run_program.h"

namespace {

int run(int argc, char** argv) {
  const std::optional<programs::Options> options = programs::parseOptions(argc, argv);
  if (!options) return 0;
  if (!options->join.empty()) {
    const std::vector<std::string> parts(options->join.begin() + 1, options->join.end());
    programs::joinPictures(parts, options->hasSize ? std::optional(options->size) : std::nullopt, options->join[0]);
    return 0;
  }
  programs::installCancelHandler();
  programs::forceExitAfterCancel("cbvh_render");
  programs::prepareOutputFolder(options->output);
  programs::requireWritable(
      {{"--save", options->savePath}, {"--export", options->exportPath}, {"--json", options->json}});
  if (!options->loadPath.empty()) {
    programs::renderSavedScene(*options);
    return 0;
  }
  const programs::ModelView view(*options);
  if (options->savesCopyByCopy()) {
    programs::saveAndRender(*options, view);
    return 0;
  }
  const programs::Comparison comparison = programs::runComparison(*options, view);
  programs::writeStandardOutput(programs::formatTable(comparison, options->details));
  if (!options->json.empty()) programs::writeTextFile(options->json, programs::formatJson(comparison));
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_render", [=] { return run(argc, argv); });
}
