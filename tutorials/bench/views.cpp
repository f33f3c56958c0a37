// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "views.h"

#include "basics/error.h"
#include "basics/parallel.h"
#include "building/memory.h"
#include "programs/view_options.h"
#include "tracing/shutter.h"
#include "tracing/trace_hits.h"

namespace programs {
namespace {

/* "view1" for the first view if it is given as numbers. */
std::string fileNameOf(const std::string& view, size_t index) {
  return view.find(',') == std::string::npos ? view : "view" + std::to_string(index + 1);
}

View makeView(const BenchOptions& options, const Camera& camera, const BuiltScene& grid, bool moves) {
  const unsigned threads = threadCount(options.buildThreads);
  View view(camera);
  if (moves) setTimes(view.primary, Shutter(), 0, view.camera.size(), view.camera.size().width);
  view.gridHits = traceClosest(grid, view.primary, threads);
  view.sample = sampleHits(view.gridHits, options.trueHits, options.seed);
  BounceSettings bounce;
  bounce.count = options.rays;
  bounce.offset = options.rayOffset * grid.bounds().diagonal();
  bounce.seed = options.seed;
  view.sets[Coherent] = coherentRays(view.primary, options.size, options.rays);
  view.sets[Incoherent] = bounceRays(view.primary, view.gridHits, bounce);
  view.bouncedGridHits = traceClosest(grid, view.sets[Incoherent], threads);
  return view;
}

} // namespace

std::vector<ReferenceView> traceReference(const BenchOptions& options, const Model& model) {
  if (options.referenceLevel < 0) return {};
  BuildSettings build;
  build.level = options.referenceLevel;
  build.threads = options.buildThreads;
  if (estimatedPeakBytes(RepresentationKind::Grid, {model, build.level}) > availableMemory())
    throw Error("not enough memory for GRID of " + model.name + " at --reference-level " + std::to_string(build.level) +
                ": expected a lower level");
  const BuiltScene grid(model, {RepresentationKind::Grid}, build);
  const unsigned threads = threadCount(options.buildThreads);
  std::vector<ReferenceView> views;
  for (const std::string& name : options.views) {
    const Camera camera = chooseCamera(name, model, grid, options.size, threads);
    std::vector<Ray> primary = primaryRays(camera);
    if (!model.poses.empty()) setTimes(primary, Shutter(), 0, camera.size(), camera.size().width);
    views.push_back({camera, traceClosest(grid, primary, threads)});
  }
  return views;
}

std::vector<View> makeViews(const BenchOptions& options, const Model& model, const BuiltScene& grid,
                            const std::vector<ReferenceView>& reference) {
  std::vector<View> views;
  for (size_t i = 0; i < options.views.size(); i++) {
    const std::string& name = options.views[i];
    const Camera camera = reference.empty()
                              ? chooseCamera(name, model, grid, options.size, threadCount(options.buildThreads))
                              : reference[i].camera;
    View view = makeView(options, camera, grid, !model.poses.empty());
    view.name = name;
    view.fileName = fileNameOf(name, i);
    view.reference = reference.empty() ? nullptr : &reference[i];
    views.push_back(std::move(view));
  }
  return views;
}

ViewInfo describe(const View& view) {
  ViewInfo info;
  info.name = view.name;
  info.camera = view.camera.description();
  for (const SurfaceHit& hit : view.gridHits) info.primaryHits += hit.hit();
  for (int set = 0; set < numRaySets; set++) info.rays[set] = view.sets[set].size();
  return info;
}

} // namespace programs
