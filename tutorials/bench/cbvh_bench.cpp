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

void measure(const cbvh::BenchOptions& options, const cbvh::Machine& machine) {
  if (!options.pictures.empty()) cbvh::prepareOutputFolder(options.pictures);
  const std::filesystem::path folder = std::filesystem::path(options.json).parent_path();
  if (!folder.empty()) cbvh::prepareOutputFolder(folder.string());
  cbvh::requireWritable({{"--json", options.json}});
  cbvh::writeStandardOutput(cbvh::formatHead(options, machine));

  /* Rewritten after each group, so that a stopped run keeps its results. */
  std::vector<cbvh::Group> groups;
  const size_t wanted = options.scenes.size() * options.levels.size();
  cbvh::runBenchmark(options, [&](const cbvh::Group& group) {
    groups.push_back(group);
    if (!options.json.empty())
      cbvh::writeTextFile(options.json, cbvh::formatJson(options, machine, groups, groups.size() == wanted));
    cbvh::writeStandardOutput(cbvh::formatTable(group));
  });
}

int run(int argc, char** argv) {
  const cbvh::Machine machine = cbvh::describeMachine();
  const std::optional<cbvh::BenchOptions> options = cbvh::parseBenchOptions(argc, argv, machine);
  if (!options) return 0;
  cbvh::installCancelHandler();
  cbvh::forceExitAfterCancel("cbvh_bench");
  measure(*options, machine);
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  return cbvh::runProgram("cbvh_bench", [=] { return run(argc, argv); });
}
