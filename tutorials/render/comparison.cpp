// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* GRID is built first and stays in memory, because the others are timed alternately with it; only one of them is in
 * memory at a time. The first representation provides the hits from which rays bounce.
 *
 * NAIVE, the largest, is next, then NAIVE-compact. If GRID and NAIVE are built, the reference of all errors is the
 * nearer hit of the two: they have the same triangles, but tens of rays in 100,000 slip between two of NAIVE's, because
 * without RTC_SCENE_FLAG_ROBUST Embree's triangle test is not watertight. */

#include "comparison.h"
#include "memory_plan.h"
#include "picture_files.h"

#include "basics/error.h"
#include "basics/file_output.h"
#include "basics/parallel.h"
#include "building/memory.h"
#include "measure/quad_size.h"
#include "measure/self_shadow.h"
#include "pictures/sampled_picture.h"
#include "programs/view_options.h"
#include "programs/warnings.h"
#include "surface/mesh.h"
#include "tracing/trace_hits.h"

#include <algorithm>
#include <cstdio>

namespace programs {
namespace {

constexpr uint32_t sampleSeed = 1; // so that every run chooses the same hits

BuildSize sizeOf(const Model& model, const BuildSettings& build) {
  return build.rates ? BuildSize(build.rates->quads, 1 + model.poses.size()) : BuildSize(model, build.level);
}

MemoryPlan planOf(const Options& options, const Model& model, const BuildSettings& build) {
  MemoryPlan plan = planMemory(options.representations, sizeOf(model, build), availableMemory());
  const auto isStatic = [](const Representation& r) { return r.isTriangulated(); };
  if (!model.poses.empty() && std::any_of(plan.built.begin(), plan.built.end(), isStatic)) {
    for (const Representation& r : plan.built)
      if (isStatic(r)) plan.skipped.push_back(optionNameOf(r.kind) + " is left out, because its triangles do not move");
    plan.built.erase(std::remove_if(plan.built.begin(), plan.built.end(), isStatic), plan.built.end());
    if (plan.built.empty()) throw Error("the triangles of naive do not move: expected another --representation");
  }
  for (const std::string& line : plan.skipped) std::fprintf(stderr, "cbvh_render: %s\n", line.c_str());
  printWarnings("cbvh_render", motionWarnings(model, plan.built));
  return plan;
}

std::vector<Ray> firstSamples(const Options& options, const Camera& camera) {
  std::vector<Ray> rays = primaryRays(camera, options.crop);
  setTimes(rays, options.shutter, 0, options.crop, options.size.width);
  return rays;
}

bool isKind(const Result& result, RepresentationKind kind) { return result.representation.kind == kind; }

class Run {
public:
  Run(const Options& options, const ModelView& view)
    : options(options),
      threads(threadCount(options.build.threads)),
      model(view.model),
      camera(view.camera),
      primary(firstSamples(options, camera)),
      build(view.build),
      plan(planOf(options, model, build)),
      files(options.output, model.name, options.size, options.crop, options.colors, options.samples) {
    if (options.trueHits) surfaces.emplace(model);
  }

  Comparison run() {
    std::optional<BuiltScene> grid;
    for (const Representation& r : plan.built)
      if (r.kind == RepresentationKind::Grid) measure(grid.emplace(model, r, build), nullptr);
      else measure(BuiltScene(model, r, build), grid ? &*grid : nullptr);
    if (Result* result = find(RepresentationKind::Grid)) finishGrid(*grid, *result);
    if (options.speed && grid)
      for (Result& result : comparison.results)
        speed.relateToGrid(result.speed, isKind(result, RepresentationKind::Grid));
    describe();
    return std::move(comparison);
  }

private:
  /* `grid` is null without GRID, and for GRID itself. */
  void measure(const BuiltScene& scene, const BuiltScene* grid) {
    const RepresentationKind kind = scene.representation().kind;
    const std::vector<SurfaceHit> hits = traceClosest(scene, primary, threads);
    writePicture(scene, hits);
    if (comparison.results.empty()) makeRays(scene, hits);
    if (seamWarning.empty()) printWarnings("cbvh_render", seamWarning = seamWarnings(model, scene.report().seams));
    Result result;
    result.representation = scene.representation();
    result.build = scene.report();
    if (options.compares()) countDisagreements(scene, hits, result);
    compareToTruth(scene, hits, result);
    if (kind == RepresentationKind::Grid || kind == RepresentationKind::Naive) addToReference(hits, kind);
    if (kind != RepresentationKind::Grid && !reference.empty() && !isReferenceItself(kind))
      result.errors = compareHits(reference, hits, camera.footprint(), scene.layout());
    writeErrorsAndAmbient(scene, hits, result.errors.has_value());
    if (!options.savePath.empty()) scene.save(options.savePath);
    if (scene.representation().isExact() && !options.exportPath.empty()) {
      const StoredMesh mesh = scene.storedMesh();
      writeObj(options.exportPath, mesh.vertices, mesh.quads);
    }
    if (options.speed && kind != RepresentationKind::Grid)
      result.speed = speed.measure(scene.representation().label(), scene, grid);
    comparison.results.push_back(result);
  }

  /* `hits` belong to the centers of pixels, which are the first samples. */
  void writePicture(const BuiltScene& scene, const std::vector<SurfaceHit>& hits) {
    const Representation& r = scene.representation();
    Phase phase(r.label() + ": picture");
    const SampledPicture picture = sampledPicture(scene, camera, options.crop, model.view.up, primary, hits,
                                                  options.samples, options.shutter, options.colors, threads);
    const std::string path = files.writePicture(r, picture.image());
    if (options.exr) files.writeExr(r, picture.linear(), primary, hits);
    if (!options.compares()) writeStandardOutput(path + "\n");
  }

  void makeRays(const BuiltScene& scene, const std::vector<SurfaceHit>& hits) {
    if (options.speed || options.compares()) makeRaySets(options, scene, primary, hits, sets);
    sample = sampleHits(hits, options.trueHits, sampleSeed);
    for (const SurfaceHit& hit : hits) comparison.primaryHits += hit.hit();
  }

  void addToReference(const std::vector<SurfaceHit>& hits, RepresentationKind kind) {
    if (kind == RepresentationKind::Grid) {
      reference = gridHits = hits;
      comparison.reference = "GRID";
      return;
    }
    comparison.reference = reference.empty() ? "NAIVE" : "the triangles of NAIVE and GRID, whichever is nearer";
    reference = reference.empty() ? hits : nearerHits(reference, hits);
  }

  bool isReferenceItself(RepresentationKind kind) const {
    return kind == RepresentationKind::Naive && gridHits.empty();
  }

  /* Requires the results of all others. */
  void finishGrid(const BuiltScene& grid, Result& result) {
    if (find(RepresentationKind::Naive))
      result.errors = compareHits(reference, gridHits, camera.footprint(), grid.layout());
    if (options.speed && comparison.results.size() == 1)
      result.speed = speed.measure(grid.representation().label(), grid, nullptr);
  }

  Result* find(RepresentationKind kind) {
    for (Result& result : comparison.results)
      if (isKind(result, kind)) return &result;
    return nullptr;
  }

  void countDisagreements(const BuiltScene& scene, const std::vector<SurfaceHit>& hits, Result& result) const {
    Phase phase(scene.representation().label() + ": any-hit queries");
    result.anyDisagreements[Coherent] = countAnyHitDisagreements(scene, primary, hits, threads);
    result.anyDisagreements[Incoherent] =
        countAnyHitDisagreements(scene, sets[Incoherent], traceClosest(scene, sets[Incoherent], threads), threads);
  }

  void compareToTruth(const BuiltScene& scene, const std::vector<SurfaceHit>& hits, Result& result) const {
    if (!surfaces) return;
    Phase phase(scene.representation().label() + ": distance to the true surface");
    result.trueErrors =
        compareToTrueSurface({model, *surfaces, primary, sample, camera.footprint()}, hits, scene.layout(), threads);
  }

  float quadPixels() const {
    const int level = model.isMesh ? 0 : build.level;
    return build.rates ? options.quadSize : medianQuadSize(options.crop.size(), reference, level);
  }

  void writeErrorsAndAmbient(const BuiltScene& scene, const std::vector<SurfaceHit>& hits, bool compared) {
    const Representation& r = scene.representation();
    Phase phase(r.label() + ": files");
    if (compared) files.writeErrors(r, pixelErrors(reference, hits, camera.footprint()), quadPixels());
    if (!options.ambientRays) return;
    const std::vector<float> light = ambient(scene, hits);
    files.writeAmbient(r, gridAmbient, light);
    if (r.kind == RepresentationKind::Grid) gridAmbient = light;
  }

  std::vector<float> ambient(const BuiltScene& scene, const std::vector<SurfaceHit>& hits) const {
    ShadowSettings settings;
    settings.offset.length = options.rayOffset * scene.bounds().diagonal();
    settings.raysPerHit = options.ambientRays;
    return ambientOcclusion({scene.tracer(), hits}, {primary, camera.footprint()}, settings, threads);
  }

  void describe() {
    comparison.model = model.name;
    comparison.faces = model.numFaces();
    comparison.vertices = model.numVertices();
    comparison.build = options.build;
    comparison.quadSize = options.autoLevel ? options.quadSize : 0.0f;
    comparison.isMesh = model.isMesh;
    comparison.size = options.size;
    comparison.camera = camera.description();
    comparison.speed = options.speed;
    comparison.compares = options.compares();
    comparison.trueHits = sample.size();
    /* A single picture was named when it was written. */
    if (options.compares() || options.exr || options.ambientRays || options.colors == HitColors::Sides)
      comparison.pictures = files.legend(comparison.reference);
    for (int set = 0; set < numRaySets; set++) comparison.rays[set] = sets[set].size();
    comparison.results = resultsInOptionOrder();
  }

  std::vector<Result> resultsInOptionOrder() const {
    std::vector<Result> ordered;
    for (const Representation& r : options.representations)
      for (const Result& result : comparison.results)
        if (result.representation.label() == r.label()) ordered.push_back(result);
    return ordered;
  }

  const Options& options;
  unsigned threads;
  const Model& model;
  const Camera camera;
  std::vector<Ray> primary;
  const BuildSettings build;
  MemoryPlan plan;
  PictureFiles files;
  RaySets sets;
  InterleavedSpeed speed{sets, options.repeat};
  std::vector<SurfaceHit> reference, gridHits;
  std::vector<float> gridAmbient;
  std::optional<TrueSurfaces> surfaces;
  std::vector<size_t> sample; // primary rays to compare with the true surface
  std::string seamWarning;    // once for all representations
  Comparison comparison;
};

} // namespace

Comparison runComparison(const Options& options, const ModelView& view) { return Run(options, view).run(); }

} // namespace programs
