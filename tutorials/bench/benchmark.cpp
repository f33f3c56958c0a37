// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* All variants of a batch stand in memory, and each round measures every variant
 * once in every combination of view, ray set, query, mode and threads. Variants
 * follow one another directly, each round in another order, so a machine that gets
 * slower for a while slows all of them, and a ratio to GRID is that of one round.
 *
 * GRID's hits are the reference of all errors: it tests the same triangles as NAIVE,
 * but closes their edges. */

#include "benchmark.h"

#include "basics/error.h"
#include "basics/file_output.h"
#include "basics/parallel.h"
#include "building/memory.h"
#include "measure/silhouettes.h"
#include "pictures/image_output.h"
#include "pictures/shading.h"
#include "programs/view_options.h"
#include "tracing/trace_hits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <unistd.h>

namespace cbvh {
namespace {

namespace fs = std::filesystem;

/* At least so long a measurement of GRID takes. */
constexpr double sampleSeconds = 0.02;

unsigned passesFor(double gridSeconds)
{
  constexpr double most = 100.0;
  return unsigned(std::min(most, std::ceil(sampleSeconds / std::max(gridSeconds, 1e-6))));
}

/* A view with the rays that every variant traces. */
struct View
{
  std::string name, fileName;
  std::unique_ptr<Camera> camera;
  std::vector<Ray> primary, sets[numRaySets];
  std::vector<SurfaceHit> gridHits, bouncedGridHits;
  std::vector<size_t> sample; // of primary rays, compared with the true surface
  std::vector<size_t> away;   // primary rays away from silhouettes
  std::vector<size_t> sampleAway;
};

std::vector<SurfaceHit> picked(const std::vector<SurfaceHit>& hits, const std::vector<size_t>& rays)
{
  std::vector<SurfaceHit> some;
  for (size_t ray : rays)
    some.push_back(hits[ray]);
  return some;
}

struct Built
{
  std::unique_ptr<BuiltScene> scene;
  VariantResult* result;
};

/* Bytes of vertices. GRID cuts patches into grids of 8 x 8 quads and stores x, y, z
 * and (u,v) of a vertex in 16 bytes; NAIVE's are vertex and index buffer and, in the
 * leaves, 44 bytes a triangle of a full Triangle4. */
size_t leafBytes(const BuiltScene& scene)
{
  const PatchLayout& layout = scene.layout();
  switch (scene.representation().kind)
  {
  case RepresentationKind::Naive:
    return layout.numVertices() * 12 + layout.numQuads() * 2 * (12 + 44);
  case RepresentationKind::Grid:
  {
    constexpr size_t block = 8;
    size_t vertices = 0;
    for (const Patch& p : layout.patches())
    {
      const size_t grids = (p.resolution + block - 1) / block, side = p.resolution + grids;
      vertices += side * side;
    }
    return vertices * 16;
  }
  default:
    return scene.report().compression.leafBytes + scene.report().compression.gridBytes;
  }
}

struct Combination
{
  const View* view;
  RaySet set;
  TraceSettings trace;
};

class GroupRun
{
public:
  /* surface: of the model, null for no errors against it. */
  GroupRun(const BenchOptions& options, const BenchScene& bench, const Model& model, const TrueSurface* surface,
           int level, const std::vector<View>& reference)
    : options(options), bench(bench), model(model), surface(surface), reference(reference),
      threads(threadCount(options.buildThreads))
  {
    build.level = level;
    build.threads = options.buildThreads;
    build.maxError = options.maxError * model.cage.bounds().diagonal();
    group.scene = bench.label;
    group.level = level;
    group.faces = model.numFaces();
    group.quads = model.layout(level).numQuads();
  }

  Group run()
  {
    const size_t available = availableMemory() / 10 * 9;
    const Batches plan = planBatches(options.representations, options.isas, group.quads, available);
    const size_t base = plan.baselines.size() * estimatedPeakBytes(RepresentationKind::Grid, group.quads);
    if (base > available)
      throw Error(sizeMessage("GRID", base, available) + "; lower --level");
    size_t count = 0;
    for (const std::vector<Variant>& batch : plan.rest)
      count += batch.size();
    group.results.reserve(plan.baselines.size() + count + plan.tooLarge.size());

    std::vector<Built> baselines;
    for (const Variant& variant : plan.baselines)
    {
      baselines.push_back(built(variant, 0));
      if (baselines.size() == 1)
      {
        grid = baselines[0].scene.get();
        makeViews(*grid);
        prepareChecks();
      }
      compare(baselines.back());
    }
    for (size_t i = 0; i < plan.rest.size(); i++)
    {
      std::vector<Built> batch;
      for (Built& b : baselines)
        batch.push_back({std::move(b.scene), b.result});
      for (const Variant& variant : plan.rest[i])
      {
        batch.push_back(built(variant, int(i)));
        compare(batch.back());
      }
      if (options.repeat > 0)
        measure(batch, "batch " + std::to_string(i + 1) + " of " + std::to_string(plan.rest.size()));
      for (size_t k = 0; k < baselines.size(); k++)
        baselines[k].scene = std::move(batch[k].scene);
    }
    for (const Variant& variant : plan.tooLarge)
    {
      VariantResult result;
      result.variant = variant;
      const size_t needed = neededBytes(plan, variant, group.quads);
      result.skipped = sizeMessage(variant.representation.label(), needed, available);
      std::fprintf(stderr, "  %s L%d: %s\n", group.scene.c_str(), group.level, result.skipped.c_str());
      group.results.push_back(result);
    }
    return std::move(group);
  }

private:
  std::string sizeMessage(const std::string& what, size_t needed, size_t available) const
  {
    char text[200];
    std::snprintf(text, sizeof(text),
                  "not enough memory: %s on %.1f million quads takes about %.1f GiB with GRID, and %.1f are free",
                  what.c_str(), double(group.quads) * 1e-6, double(needed) / (1 << 30), double(available) / (1 << 30));
    return text;
  }

  Built built(const Variant& variant, int batch)
  {
    build.isa = variant.isa;
    VariantResult result;
    result.variant = variant;
    result.batch = batch;
    Built b{std::make_unique<BuiltScene>(model, variant.representation, build), nullptr};
    result.build = b.scene->report();
    result.leafBytes = leafBytes(*b.scene);
    result.innerBytes = result.build.liveBytes - std::min(result.build.liveBytes, result.leafBytes);
    group.results.push_back(result); // never more than reserved: pointers stay
    b.result = &group.results.back();
    return b;
  }

  void makeViews(const BuiltScene& grid)
  {
    group.diagonal = grid.bounds().diagonal();
    for (size_t i = 0; i < options.views.size(); i++)
    {
      View view;
      view.name = options.views[i];
      view.fileName = view.name.find(',') == std::string::npos ? view.name : "view" + std::to_string(i + 1);
      view.camera = std::make_unique<Camera>(reference.empty()
                                               ? chooseCamera(view.name, model, grid, options.size, threads)
                                               : *reference[i].camera);
      view.primary = primaryRays(*view.camera);
      view.gridHits = traceClosest(grid, view.primary, threads);
      view.sample = sampleOfHits(view.gridHits, options.trueHits, options.seed);
      view.away = hitsAwayFromSilhouettes(view.primary, view.gridHits, *view.camera);
      std::set_intersection(view.sample.begin(), view.sample.end(), view.away.begin(), view.away.end(),
                            std::back_inserter(view.sampleAway));
      BounceSettings bounce;
      bounce.count = options.rays;
      bounce.offset = options.rayOffset * float(group.diagonal);
      bounce.seed = options.seed;
      view.sets[Coherent] = coherentRays(view.primary, options.size, options.rays);
      view.sets[Incoherent] = bounceRays(view.primary, view.gridHits, bounce);
      view.bouncedGridHits = traceClosest(grid, view.sets[Incoherent], threads);

      ViewInfo info;
      info.name = view.name;
      info.camera = view.camera->description();
      for (const SurfaceHit& hit : view.gridHits)
        info.primaryHits += hit.hit();
      for (int set = 0; set < numRaySets; set++)
        info.rays[set] = view.sets[set].size();
      group.views.push_back(info);
      views.push_back(std::move(view));
    }
  }

  void compare(const Built& b)
  {
    Phase phase(title(b.result->variant) + ": hits");
    for (size_t i = 0; i < views.size(); i++)
    {
      const View& view = views[i];
      const float footprint = view.camera->footprint();
      const std::vector<SurfaceHit> hits = traceClosest(*b.scene, view.primary, threads);
      ViewResult result;
      result.view = view.name;
      result.errors = compareHits(view.gridHits, hits, footprint, b.scene->layout());
      result.away =
        compareHits(picked(view.gridHits, view.away), picked(hits, view.away), footprint, b.scene->layout());
      if (!reference.empty())
        result.toReference = compareHits(reference[i].gridHits, hits, footprint, b.scene->layout());
      if (surface)
      {
        const TrueView trueView{model, *surface, view.primary, view.sample, footprint};
        result.toTrue = compareToTrueSurface(trueView, hits, b.scene->layout(), threads);
        const Representation& what = b.scene->representation();
        if (what.kind == RepresentationKind::CLeaf && what.frameLevel != autoFrameLevel)
        {
          const auto bins = [&](const std::vector<size_t>& sample) {
            return heightBins({model, *surface, view.primary, sample, footprint}, view.gridHits,
                              {b.scene->layout(), group.level, what.frameLevel}, threads);
          };
          result.bins = bins(view.sample);
          result.binsAway = bins(view.sampleAway);
        }
      }
      const std::vector<SurfaceHit> bounced = traceClosest(*b.scene, view.sets[Incoherent], threads);
      result.bounced = compareHits(view.bouncedGridHits, bounced, footprint, b.scene->layout());
      if (wantsPictures())
        writePictures(b.result->variant, view, hits, result);
      b.result->views.push_back(result);
      if (options.checks.any() && b.scene.get() != grid)
        for (ShadowCheck& check :
             robustness->shadows(*grid, *b.scene, {view.name, view.primary, view.gridHits, footprint}, hits))
          b.result->checks.shadows.push_back(std::move(check));
    }
    if (options.checks.any() && b.scene.get() != grid)
    {
      b.result->checks.leaks = robustness->leaks(*grid, *b.scene);
      b.result->checks.sheets = robustness->sheets(*b.scene);
    }
  }

  void prepareChecks()
  {
    std::vector<int> frameLevels;
    for (const Representation& r : options.representations)
      frameLevels.push_back(r.frameLevel);
    robustness = std::make_unique<Robustness>(model, build, frameLevels, options.checks, options.seed);
    group.quadWidth = robustness->quadWidth();
  }

  bool wantsPictures() const
  {
    const std::vector<int>& levels = options.pictureLevels;
    return !options.pictures.empty() &&
           (levels.empty() || std::find(levels.begin(), levels.end(), group.level) != levels.end());
  }

  void writePictures(const Variant& variant, const View& view, const std::vector<SurfaceHit>& hits,
                     ViewResult& result) const
  {
    std::string stem = bench.label + "_L" + std::to_string(group.level) + "_" + view.fileName + "_" +
                       variant.representation.fileStem() + (options.isas.size() > 1 ? "_" + variant.isa : "");
    std::replace(stem.begin(), stem.end(), ':', '_');
    result.picture = stem + ".png";
    writePng((fs::path(options.pictures) / result.picture).string(),
             shadeHits(options.size, view.primary, hits, model.view.up));
    if (variant.representation.kind == RepresentationKind::Grid)
      return;
    result.errorMap = stem + "_error.png";
    writePng((fs::path(options.pictures) / result.errorMap).string(),
             errorHeatMap(options.size, pixelErrors(view.gridHits, hits, view.camera->footprint())));
  }

  void measure(std::vector<Built>& batch, const std::string& what)
  {
    std::vector<Combination> combinations;
    for (const View& view : views)
      for (RaySet set : options.sets)
        for (Query query : options.queries)
          for (TraceMode mode : options.modes)
            for (unsigned n : options.threads)
              if (!view.sets[set].empty())
                combinations.push_back({&view, set, {query, mode, set == Coherent, n, 1}});

    Phase phase(group.scene + " L" + std::to_string(group.level) + ": speed, " + what);
    const size_t samples = combinations.size() * batch.size() * (size_t(options.repeat) + 1);
    size_t taken = 0;
    for (int round = -1; round < options.repeat; round++) // the first warms up
      for (size_t c = 0; c < combinations.size(); c++)
      {
        Combination& combination = combinations[c];
        const std::vector<Ray>& rays = combination.view->sets[combination.set];
        std::vector<TraceTiming> timings(batch.size());
        for (size_t k = 0; k < batch.size(); k++)
        {
          const size_t turn = (k + size_t(round + 1)) % batch.size();
          const size_t i = round % 2 ? batch.size() - 1 - turn : turn;
          timings[i] = timeTrace(*batch[i].scene, rays, combination.trace);
          phase.update(double(++taken) / double(samples));
        }
        if (round < 0)
          combination.trace.passes = passesFor(timings[0].seconds);
        else
          note(batch, c, combination, timings);
      }
  }

  /* One round of one combination. Records have the same index in every result. */
  void note(const std::vector<Built>& batch, size_t index, const Combination& combination,
            const std::vector<TraceTiming>& timings) const
  {
    for (size_t i = 0; i < batch.size(); i++)
    {
      VariantResult& result = *batch[i].result;
      if (result.speeds.size() <= index)
      {
        Speed speed;
        speed.view = combination.view->name;
        speed.set = combination.set;
        speed.trace = combination.trace;
        speed.rays = combination.view->sets[combination.set].size();
        result.speeds.push_back(speed);
      }
      size_t grid = 0; // baselines come first
      while (batch[grid].result->variant.isa != result.variant.isa)
        grid++;
      Speed& speed = result.speeds[index];
      speed.hits = timings[i].hits;
      speed.seconds.push_back(timings[i].seconds);
      speed.toGrid.push_back(timings[grid].seconds / timings[i].seconds);
    }
  }

  std::string title(const Variant& variant) const
  {
    return group.scene + " L" + std::to_string(group.level) + ", " + variant.representation.label() +
           (options.isas.size() > 1 ? " " + variant.isa : "");
  }

  const BenchOptions& options;
  const BenchScene& bench;
  const Model& model;
  const TrueSurface* surface;
  const std::vector<View>& reference;
  unsigned threads;
  BuildSettings build;
  std::vector<View> views;
  const BuiltScene* grid = nullptr; // the first baseline
  std::unique_ptr<Robustness> robustness;
  Group group;
};

/* Camera and hits of the reference level, a view each. */
std::vector<View> traceReference(const BenchOptions& options, const Model& model)
{
  BuildSettings build;
  build.level = options.referenceLevel;
  build.threads = options.buildThreads;
  const size_t quads = model.layout(build.level).numQuads();
  if (estimatedPeakBytes(RepresentationKind::Grid, quads) > availableMemory())
    throw Error("not enough memory for GRID at --reference-level " + std::to_string(build.level) + " of " + model.name);
  const BuiltScene grid(model, {RepresentationKind::Grid}, build);
  std::vector<View> views(options.views.size());
  for (size_t i = 0; i < views.size(); i++)
  {
    views[i].camera = std::make_unique<Camera>(
      chooseCamera(options.views[i], model, grid, options.size, threadCount(options.buildThreads)));
    views[i].gridHits = traceClosest(grid, primaryRays(*views[i].camera), threadCount(options.buildThreads));
  }
  return views;
}

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

} // namespace

void runBenchmark(const BenchOptions& options, const std::function<void(const Group&)>& done)
{
  std::unique_ptr<TemporaryFolder> temporary;
  if (options.maps.empty())
    temporary = std::make_unique<TemporaryFolder>();
  for (const BenchScene& bench : options.scenes)
  {
    SceneSettings settings = bench.settings;
    settings.mapFolder = temporary ? temporary->path.string() : options.maps;
    settings.threads = options.buildThreads;
    std::string warning;
    Model model = loadScene(settings, warning);
    for (Placement& copy : model.copies)
      copy.origin += options.position;
    if (!warning.empty())
      std::fprintf(stderr, "cbvh_bench: warning: %s\n", warning.c_str());
    std::vector<View> reference;
    if (options.referenceLevel >= 0)
      reference = traceReference(options, model);
    std::optional<TrueSurface> surface;
    if (options.trueHits)
      surface.emplace(model);
    for (int level : options.levels)
      done(GroupRun(options, bench, model, surface ? &*surface : nullptr, level, reference).run());
  }
}

} // namespace cbvh
