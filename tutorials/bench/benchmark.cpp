// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "benchmark.h"

#include "group_run.h"
#include "basics/file_output.h"
#include "programs/warnings.h"

#include <filesystem>
#include <memory>
#include <unistd.h>

namespace cbvh {
namespace {

namespace fs = std::filesystem;

/* For generated height maps, gone at the end. */
class TemporaryFolder
{
public:
  TemporaryFolder() : path(fs::temp_directory_path() / ("cbvh_bench-" + std::to_string(getpid())))
  {
    prepareOutputFolder(path.string());
  }
  ~TemporaryFolder()
  {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path path;
};

Model loadModel(const BenchOptions& options, const BenchScene& bench, const std::string& mapFolder)
{
  SceneSettings settings = bench.settings;
  settings.mapFolder = mapFolder;
  settings.threads = options.buildThreads;
  std::string warnings;
  Model model = loadScene(settings, warnings);
  for (Placement& copy : model.copies)
    copy.origin += options.position;
  printWarnings("cbvh_bench", warnings);
  return model;
}

} // namespace

void runBenchmark(const BenchOptions& options, const std::function<void(const Group&)>& done)
{
  std::unique_ptr<TemporaryFolder> temporary;
  if (options.maps.empty())
    temporary = std::make_unique<TemporaryFolder>();
  for (const BenchScene& bench : options.scenes)
  {
    options.libraries.front().use();
    const Model model = loadModel(options, bench, temporary ? temporary->path.string() : options.maps);
    const std::vector<ReferenceView> reference = traceReference(options, model);
    std::optional<TrueSurface> surface;
    if (options.trueHits)
      surface.emplace(model);
    for (int level : options.levels)
      done(runGroup({options, bench.label, model, surface ? &*surface : nullptr, reference, level}));
  }
}

} // namespace cbvh
