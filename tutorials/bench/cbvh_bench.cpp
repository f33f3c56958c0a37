// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Measures memory, build time, speed and error of representations and writes JSON. */

#include "benchmark.h"
#include "json.h"
#include "machine.h"
#include "options.h"
#include "text.h"
#include "basics/file_output.h"
#include "basics/progress.h"
#include "programs/outputs.h"
#include "programs/run_program.h"

#include <filesystem>

namespace {

void measure(const programs::BenchOptions& options, const programs::Machine& machine) {
  if (!options.pictures.empty()) programs::prepareOutputFolder(options.pictures);
  const std::filesystem::path folder = std::filesystem::path(options.json).parent_path();
  if (!folder.empty()) programs::prepareOutputFolder(folder.string());
  programs::requireWritable({{"--json", options.json}});
  programs::writeStandardOutput(programs::formatHead(options, machine));

  /* Rewritten after each group, so that a stopped run keeps its results. */
  std::vector<programs::Group> groups;
  const size_t wanted = options.scenes.size() * options.levels.size();
  programs::runBenchmark(options, [&](const programs::Group& group) {
    groups.push_back(group);
    if (!options.json.empty())
      programs::writeTextFile(options.json, programs::formatJson(options, machine, groups, groups.size() == wanted));
    programs::writeStandardOutput(programs::formatTable(group));
  });
}

int run(int argc, char** argv) {
  const programs::Machine machine = programs::describeMachine();
  const std::optional<programs::BenchOptions> options = programs::parseBenchOptions(argc, argv, machine);
  if (!options) return 0;
  programs::installCancelHandler();
  programs::forceExitAfterCancel("cbvh_bench");
  measure(*options, machine);
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_bench", [=] { return run(argc, argv); });
}
