// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "benchmark.h"

#include "group_run.h"
#include "programs/program_scene.h"

namespace programs {
namespace {

Model loadModel(const BenchOptions& options, const BenchScene& bench) {
  SceneSettings settings = bench.settings;
  settings.threads = options.buildThreads;
  Model model = loadProgramScene("cbvh_bench", settings);
  for (Placement& copy : model.copies) copy.origin += options.position;
  return model;
}

} // namespace

void runBenchmark(const BenchOptions& options, const std::function<void(const Group&)>& done) {
  for (const BenchScene& bench : options.scenes) {
    options.libraries.front().use();
    const Model model = loadModel(options, bench);
    if (&bench == &options.scenes.front()) // all scenes have the same motion, or none
      printWarnings("cbvh_bench", motionWarnings(model, options.representations));
    const std::vector<ReferenceView> reference = traceReference(options, model);
    std::optional<TrueSurfaces> surfaces;
    if (options.trueHits && model.poses.empty()) // unknown for later time steps
      surfaces.emplace(model);
    for (int level : options.levels)
      done(runGroup({options, bench.label, model, surfaces ? &*surfaces : nullptr, reference, level}));
  }
}

} // namespace programs
