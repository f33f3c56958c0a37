// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* GRID of each ISA and library is always in memory; other variants are in batches that fit. Only speed is measured
 * alternately; errors, pictures and checks follow a variant's build. */

#include "group_run.h"

#include "built_variant.h"
#include "hit_agreement.h"
#include "speed.h"
#include "view_errors.h"
#include "view_pictures.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "building/memory.h"
#include "programs/warnings.h"
#include "tracing/trace_hits.h"

#include <algorithm>
#include <cstdio>

namespace programs {
namespace {

Group newGroup(const GroupSettings& settings) {
  Group group;
  group.scene = settings.scene;
  group.level = settings.level;
  group.faces = settings.model.numFaces();
  group.quads = settings.model.layout(settings.level).numQuads();
  return group;
}

BuildSettings buildSettings(const GroupSettings& settings) {
  BuildSettings build;
  build.level = settings.level;
  build.threads = settings.options.buildThreads;
  build.device = settings.options.device;
  if (settings.options.maxError) build.maxError = *settings.options.maxError * settings.model.cage.bounds().diagonal();
  return build;
}

std::vector<bool> compresses(const std::vector<Library>& libraries) {
  std::vector<bool> all;
  for (const Library& library : libraries) all.push_back(library.compresses());
  return all;
}

std::vector<int> frameLevels(const std::vector<Representation>& representations) {
  std::vector<int> levels;
  for (const Representation& r : representations) levels.push_back(r.frameLevel);
  return levels;
}

class Comparisons {
public:
  /* `grid` is the first baseline. Adds descriptions of GRID and views to the group. The settings must outlive this
   * object. */
  Comparisons(const GroupSettings& settings, const BuildSettings& build, const BuiltScene& grid, Group& group)
    : errors{settings.model, settings.surfaces, threadCount(build.threads)},
      all(makeViews(settings.options, settings.model, grid, settings.reference)),
      pictures(settings.options, settings.scene, settings.model, settings.level),
      robustness(settings.model, build, frameLevels(settings.options.representations), settings.options.checks,
                 settings.options.seed) {
    group.diagonal = grid.bounds().diagonal();
    group.quadWidth = robustness.quadWidth();
    for (const View& view : all) group.views.push_back(describe(view));
  }

  const std::vector<View>& views() const { return all; }

  /* Computes errors, pictures and checks. `grid` must be of the same library. */
  void add(const BuiltVariant& built, const BuiltScene& grid) const {
    const BuiltScene& scene = built.use();
    VariantResult& result = built.result();
    const bool checked = &scene != &grid;
    for (const View& view : all) {
      const std::vector<SurfaceHit> hits = traceClosest(scene, view.primary, errors.threads);
      result.views.push_back(errorsInView(errors, view, scene, hits));
      pictures.write(view, result.variant, scene, hits, result.views.back());
      if (checked) addChecksOfView(view, grid, scene, hits, result.checks);
    }
    if (checked) {
      result.checks.leaks = robustness.leaks(grid, scene);
      result.checks.sheets = robustness.sheets(scene);
    }
  }

private:
  void addChecksOfView(const View& view, const BuiltScene& grid, const BuiltScene& scene,
                       const std::vector<SurfaceHit>& hits, CheckResult& checks) const {
    const CheckedView checkedView{view.name, view.primary, view.gridHits, view.camera.footprint()};
    for (ShadowCheck& check : robustness.shadows(grid, scene, checkedView, hits))
      checks.shadows.push_back(std::move(check));
    for (CrossingCheck& check : robustness.crossings(scene.representation(), checkedView))
      checks.crossings.push_back(std::move(check));
  }

  ErrorSettings errors;
  std::vector<View> all;
  ViewPictures pictures;
  Robustness robustness;
};

class GroupRun {
public:
  explicit GroupRun(const GroupSettings& settings)
    : settings(settings),
      build(buildSettings(settings)),
      group(newGroup(settings)),
      available(availableMemory() / 10 * 9), // the rest is for rays and hits
      size(settings.model, settings.level),
      plan(planBatches(settings.options.representations, settings.options.isas, size, available,
                       compresses(settings.options.libraries))) {
    const size_t needed = baselineBytes(plan, size);
    if (needed > available)
      throw Error(sizeMessage("GRID", group.quads, needed, available) + ": expected a lower --level");
  }

  Group run() {
    for (const Variant& variant : plan.baselines) add(variant, 0);
    for (size_t i = 0; i < plan.batches.size(); i++) {
      for (const Variant& variant : plan.batches[i]) add(variant, int(i));
      if (settings.options.libraries.size() > 1)
        compareLibraries(settings.options, comparisons->views(), built, title() + ": hits of the libraries");
      if (settings.options.repeat > 0)
        measureSpeed(settings.options, comparisons->views(), built,
                     title() + ": speed, batch " + std::to_string(i + 1) + " of " +
                         std::to_string(plan.batches.size()));
      built.erase(built.begin() + ptrdiff_t(plan.baselines.size()), built.end());
    }
    for (const Variant& variant : plan.tooLarge)
      skip(variant,
           sizeMessage(variant.representation.label(), group.quads, neededBytes(plan, variant, size), available));
    for (const Variant& variant : plan.unsupported)
      skip(variant, variant.representation.label() + " is not supported by " + libraryOf(variant).description());
    return std::move(group);
  }

private:
  void add(const Variant& variant, int batch) {
    built.emplace_back(settings.model, variant, build, libraryOf(variant), group);
    built.back().result().batch = batch;
    if (!comparisons) {
      printWarnings("cbvh_bench", seamWarnings(settings.model, built[0].use().report().seams));
      comparisons = std::make_unique<Comparisons>(settings, build, built[0].use(), group);
    }
    Phase phase(title() + ", " + variant.representation.label() +
                (settings.options.isas.size() > 1 ? " " + variant.isa : "") +
                (settings.options.libraries.size() > 1 ? " " + libraryOf(variant).name() : "") + ": hits");
    const auto grid = std::find_if(built.begin(), built.end(),
                                   [&](const BuiltVariant& b) { return b.variant().library == variant.library; });
    comparisons->add(built.back(), grid->use());
  }

  const Library& libraryOf(const Variant& variant) const { return settings.options.libraries[variant.library]; }

  void skip(const Variant& variant, const std::string& why) {
    VariantResult result;
    result.variant = variant;
    result.library = libraryOf(variant).name();
    result.skipped = why;
    std::fprintf(stderr, "  %s: %s\n", title().c_str(), result.skipped.c_str());
    group.results.push_back(std::move(result));
  }

  std::string title() const { return group.scene + " L" + std::to_string(group.level); }

  const GroupSettings& settings;
  BuildSettings build;
  Group group;
  size_t available; // bytes
  const BuildSize size;
  Batches plan;
  std::vector<BuiltVariant> built; // baselines, followed by a batch
  std::unique_ptr<Comparisons> comparisons;
};

} // namespace

Group runGroup(const GroupSettings& settings) { return GroupRun(settings).run(); }

} // namespace programs
