// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* GRID is always built and stays: its hits make the rays, and every other representation
 * is timed in turns with it. Of the others one is in memory at a time.
 *
 * NAIVE, the largest, goes first: where it is there, the reference of all errors is what
 * NAIVE or GRID hits, whichever is nearer. Both have the same triangles, but tens of rays
 * in 100,000 slip between two of NAIVE's: Embree's test without RTC_SCENE_FLAG_ROBUST does
 * not close edges, that of GRID does. */

#include "comparison.h"
#include "speed.h"

#include "basics/error.h"
#include "basics/file_output.h"
#include "basics/parallel.h"
#include "building/memory.h"
#include "measure/self_shadow.h"
#include "pictures/image_output.h"
#include "pictures/shading.h"
#include "programs/view_options.h"
#include "tracing/trace_hits.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

namespace cbvh {
namespace {

constexpr uint32_t sampleSeed = 1; // any: the same hits in every run

std::string outputPath(const Options& options, const std::string& name)
{
  return (std::filesystem::path(options.output) / name).string();
}

Model loadModel(const Options& options)
{
  std::string warning;
  Model model = loadScene(options.scene, warning);
  if (!warning.empty())
    std::fprintf(stderr, "cbvh_render: warning: %s\n", warning.c_str());
  return model;
}

/* Which of the others to build, NAIVE first. GRID is not among them. */
std::vector<Representation> buildOrder(const std::vector<Representation>& asked)
{
  std::vector<Representation> order;
  for (bool naive : {true, false})
    for (const Representation& r : asked)
      if ((r.kind == RepresentationKind::Naive) == naive && r.kind != RepresentationKind::Grid)
        order.push_back(r);
  return order;
}

void checkMemory(const Options& options, const Model& model)
{
  const size_t quads = model.layout(options.build.level).numQuads();
  const size_t available = availableMemory();
  const size_t grid = estimatedPeakBytes(RepresentationKind::Grid, quads);
  Representation largest{RepresentationKind::Grid};
  size_t needed = grid;
  for (const Representation& r : buildOrder(options.representations))
    if (grid + estimatedPeakBytes(r.kind, quads) > needed)
    {
      largest = r;
      needed = grid + estimatedPeakBytes(r.kind, quads);
    }
  if (needed <= available)
    return;
  char text[256];
  std::snprintf(text, sizeof(text),
                "not enough memory: %s on %.1f million quads, beside GRID, takes about %.1f GiB, and %.1f are free; "
                "lower --level or leave it out of --representation",
                largest.label().c_str(), double(quads) * 1e-6, double(needed) / (1 << 30),
                double(available) / (1 << 30));
  throw Error(text);
}

class Run
{
public:
  explicit Run(const Options& options)
    : options(options), build(options.build), threads(threadCount(options.build.threads)), model(loadModel(options))
  {
    checkMemory(options, model);
  }

  Comparison run()
  {
    const BuiltScene grid(model, {RepresentationKind::Grid}, options.build);
    look(grid);
    Result gridResult = resultOf(grid, gridHits);
    if (askedForGrid())
      writePictures(grid, gridHits);
    const std::vector<Representation> order = buildOrder(options.representations);
    for (const Representation& r : order)
      comparison.results.push_back(compared(r, grid));
    if (referenceHits != &gridHits)
      gridResult.errors = compareHits(*referenceHits, gridHits, footprint, grid.layout());
    if (options.speed && order.empty())
      speed.measureGrid(grid);
    speed.noteGrid(gridResult);
    comparison.results = inOrderAskedFor(gridResult);
    return std::move(comparison);
  }

private:
  std::vector<SurfaceHit> traced(const BuiltScene& scene) const
  {
    Phase phase(scene.representation().label() + ": picture");
    return traceClosest(scene, primary, threads);
  }

  /* All that comes from GRID alone: the view, its rays, and what they hit. */
  void look(const BuiltScene& grid)
  {
    const Camera camera = chooseCamera(options.view, model, grid, options.size, threads);
    footprint = camera.footprint();
    build.pixelBound = {options.maxPixelError, camera.eye(), footprint};
    primary = primaryRays(camera);
    gridHits = traced(grid);
    BounceSettings bounce;
    bounce.count = options.rays;
    bounce.offset = options.rayOffset * grid.bounds().diagonal();
    sets[Coherent] = coherentRays(primary, options.size, options.rays);
    sets[Incoherent] = bounceRays(primary, gridHits, bounce);
    if (options.ambientRays)
      gridAmbient = ambient(grid, gridHits);
    describe(camera);
    if (options.trueHits)
      surface.emplace(model);
    sample = sampleOfHits(gridHits, options.trueHits, sampleSeed);
    comparison.trueHits = sample.size();
  }

  void describe(const Camera& camera)
  {
    comparison.model = model.name;
    comparison.faces = model.numFaces();
    comparison.vertices = model.numVertices();
    comparison.build = options.build;
    comparison.size = options.size;
    comparison.camera = camera.description();
    comparison.speed = options.speed;
    comparison.reference = "GRID";
    for (int set = 0; set < numRaySets; set++)
      comparison.rays[set] = sets[set].size();
    for (const SurfaceHit& hit : gridHits)
      comparison.primaryHits += hit.hit();
  }

  bool askedForGrid() const
  {
    const auto isGrid = [](const Representation& r) { return r.kind == RepresentationKind::Grid; };
    return std::any_of(options.representations.begin(), options.representations.end(), isGrid);
  }

  /* What a scene says by itself. */
  Result resultOf(const BuiltScene& scene, const std::vector<SurfaceHit>& hits) const
  {
    Result result;
    result.representation = scene.representation();
    result.build = scene.report();
    countDisagreements(scene, hits, result);
    compareToTruth(scene, hits, result);
    return result;
  }

  /* Builds a representation for as long as it takes. */
  Result compared(const Representation& representation, const BuiltScene& grid)
  {
    const BuiltScene scene(model, representation, build);
    const std::vector<SurfaceHit> hits = traced(scene);
    Result result = resultOf(scene, hits);
    writePictures(scene, hits);
    if (options.speed)
      speed.measure(grid, scene, result);
    if (representation.kind == RepresentationKind::Naive)
    {
      nearest = nearerHits(gridHits, hits);
      referenceHits = &nearest;
      comparison.reference = "the triangles of NAIVE and GRID, whichever is nearer";
    }
    result.errors = compareHits(*referenceHits, hits, footprint, scene.layout());
    return result;
  }

  /* GRID, if only there to compare with, first. */
  std::vector<Result> inOrderAskedFor(const Result& gridResult) const
  {
    std::vector<Result> all = comparison.results, ordered;
    all.push_back(gridResult);
    if (!askedForGrid())
      ordered.push_back(gridResult);
    for (const Representation& r : options.representations)
      for (const Result& result : all)
        if (result.representation.label() == r.label())
          ordered.push_back(result);
    return ordered;
  }

  void countDisagreements(const BuiltScene& scene, const std::vector<SurfaceHit>& hits, Result& result) const
  {
    Phase phase(scene.representation().label() + ": any hit against closest hit");
    result.anyDisagreements[Coherent] = countAnyHitDisagreements(scene, primary, hits, threads);
    result.anyDisagreements[Incoherent] = countAnyHitDisagreements(
      scene, sets[Incoherent], traceClosest(scene, sets[Incoherent], threads), threads);
  }

  void compareToTruth(const BuiltScene& scene, const std::vector<SurfaceHit>& hits, Result& result) const
  {
    if (!surface)
      return;
    Phase phase(scene.representation().label() + ": distance to the true surface");
    result.trueErrors =
      compareToTrueSurface({model, *surface, primary, sample, footprint}, hits, scene.layout(), threads);
  }

  void writePictures(const BuiltScene& scene, const std::vector<SurfaceHit>& hits) const
  {
    Phase phase(scene.representation().label() + ": files");
    const std::string stem = model.name + "_" + scene.representation().fileStem();
    writePng(outputPath(options, stem + ".png"), shadeHits(options.size, primary, hits, model.view.up));
    writeHitsExr(outputPath(options, stem + ".exr"), options.size, primary, hits);
    if (scene.representation().kind != RepresentationKind::Grid)
      writePng(outputPath(options, stem + "_error.png"),
               errorHeatMap(options.size, pixelErrors(gridHits, hits, footprint)));
    if (scene.representation().kind != RepresentationKind::Grid && options.ambientRays)
      writePng(outputPath(options, stem + "_ambient.png"),
               compareAmbient(options.size, gridAmbient, ambient(scene, hits)));
  }

  std::vector<float> ambient(const BuiltScene& scene, const std::vector<SurfaceHit>& hits) const
  {
    ShadowSettings settings;
    settings.offset.length = options.rayOffset * scene.bounds().diagonal();
    settings.raysPerHit = options.ambientRays;
    return ambientOcclusion({scene.tracer(), hits}, {primary, footprint}, settings, threads);
  }

  const Options& options;
  BuildSettings build;
  unsigned threads;
  Model model;
  float footprint = 0;
  std::vector<Ray> primary;
  RaySets sets;
  SpeedInTurns speed{sets, options.repeat};
  std::vector<SurfaceHit> gridHits, nearest;
  std::vector<float> gridAmbient;
  const std::vector<SurfaceHit>* referenceHits = &gridHits;
  std::optional<TrueSurface> surface;
  std::vector<size_t> sample; // of the primary rays, compared with the true surface
  Comparison comparison;
};

} // namespace

Comparison runComparison(const Options& options)
{
  return Run(options).run();
}

} // namespace cbvh
