// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* GRID is always built and stays: its hits make the rays, and every other
 * representation is timed in turns with it, so that both see the same machine. Of
 * the others one is in memory at a time. NAIVE, the largest, goes first: where it is
 * there, its hits are the reference of all errors, but for the rays, tens in 100,000,
 * that slip between two of its triangles (Embree's test without RTC_SCENE_FLAG_ROBUST
 * does not close edges) while GRID, the same triangles tested otherwise, stops them. */

#include "comparison.h"

#include "cage_validation.h"
#include "error.h"
#include "file_output.h"
#include "obj_reader.h"
#include "parallel.h"
#include "shading.h"
#include "tracing.h"

#include "scenes/cube.h"
#include "scenes/trex.h"

#include <cstdio>
#include <filesystem>

namespace cbvh {
namespace {

constexpr float fieldOfView = 35.0f;

std::string outputPath(const Options& options, const std::string& name)
{
  return (std::filesystem::path(options.output) / name).string();
}

Model loadCage(const Options& options)
{
  constexpr float defaultAmplitude = 0.006f;
  Model model;
  model.cage = readObj(options.cagePath);
  model.name = std::filesystem::path(options.cagePath).stem().string();
  if (options.heightPath.empty())
    return model;
  HeightMap map = HeightMap::read(options.heightPath);
  const float scale = options.amplitude.value_or(defaultAmplitude) * model.cage.bounds().diagonal();
  if (model.cage.hasUVs())
    model.displacement = displaceByUVs(model.cage, std::move(map), scale);
  else
  {
    if (!map.hasConstantBorder())
      std::fprintf(stderr, "cbvh_render: warning: %s has no texture coordinates: each face gets the whole map, and the "
                           "surface tears between faces, as the border of the map is not of one height\n",
                   options.cagePath.c_str());
    model.displacement = displaceByFace(model.cage, std::move(map), scale);
  }
  return model;
}

Model loadModel(const Options& options)
{
  Model model;
  if (options.scene == "cube")
    model = makeCube(options.amplitude.value_or(cubeAmplitude));
  else if (options.scene == "trex")
  {
    TrexSettings settings;
    settings.amplitude = options.amplitude.value_or(settings.amplitude) * (options.rough ? trexRoughFactor : 1.0f);
    settings.mapPath = outputPath(options, "trex_height.exr");
    settings.threads = options.build.threads;
    model = makeTrex(settings);
  }
  else
    model = loadCage(options);
  validateCage(model.cage);
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

void checkMemory(const Options& options, const Cage& cage)
{
  const size_t quads = PatchLayout(cage, options.build.level).numQuads();
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

/* The close view stands before the point that the full view shows at a given place
 * of the picture, or at the nearest one to it where there is surface. */
Camera closeCamera(const Camera& full, const BuiltScene& grid, const ViewHints& hints, unsigned threads)
{
  const ImageSize size = full.size();
  const std::vector<Ray> rays = primaryRays(full);
  const std::vector<SurfaceHit> hits = traceClosest(grid, rays, threads);
  const float cx = hints.closePoint.x * float(size.width), cy = hints.closePoint.y * float(size.height);
  float best = INFINITY;
  size_t pixel = 0;
  for (size_t i = 0; i < hits.size(); i++)
  {
    const float dx = float(i % size_t(size.width)) - cx, dy = float(i / size_t(size.width)) - cy;
    if (hits[i].hit() && dx * dx + dy * dy < best)
    {
      best = dx * dx + dy * dy;
      pixel = i;
    }
  }
  if (best == INFINITY)
    throw Error("the full view shows no surface to look at closely");
  const Vec3f target = rays[pixel].origin + hits[pixel].t * rays[pixel].direction;
  const float distance = hints.closeDistance * grid.bounds().diagonal();
  return Camera(target - distance * rays[pixel].direction, target, hints.up, full.fov(), size);
}

Camera chooseCamera(const Options& options, const Model& model, const BuiltScene& grid, unsigned threads)
{
  if (options.view != "full" && options.view != "close")
    return parseView(options.view, model.view.up, options.size);
  const Box3f cage = model.cage.bounds(), surface = grid.bounds();
  const Vec3f below = cage.lower - surface.lower, above = surface.upper - cage.upper;
  const float beyond = std::max({0.0f, below.x, below.y, below.z, above.x, above.y, above.z});
  const Camera full = Camera::fit(model.cage.positions, beyond, model.view, fieldOfView, options.size);
  return options.view == "full" ? full : closeCamera(full, grid, model.view, threads);
}

double median(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

class Run
{
public:
  explicit Run(const Options& options)
    : options(options), threads(threadCount(options.build.threads)), model(loadModel(options))
  {
    checkMemory(options, model.cage);
  }

  Comparison run()
  {
    const BuiltScene grid(model, {RepresentationKind::Grid}, options.build);
    if (grid.report().quads == 0 || !isFinite(grid.bounds().lower) || !isFinite(grid.bounds().upper))
      throw Error(model.name + ": Embree makes no surface of this cage");
    const Camera camera = chooseCamera(options, model, grid, threads);
    footprint = camera.footprint();
    primary = primaryRays(camera);
    gridHits = traced(grid);
    makeRaySets(grid);
    describe(camera);

    bool askedForGrid = false;
    for (const Representation& r : options.representations)
      askedForGrid |= r.kind == RepresentationKind::Grid;
    const std::vector<Representation> order = buildOrder(options.representations);
    Result gridResult;
    gridResult.representation = grid.representation();
    gridResult.build = grid.report();
    countDisagreements(grid, gridHits, gridResult);
    if (askedForGrid)
      writePictures(grid, gridHits);

    referenceHits = &gridHits;
    for (const Representation& r : order)
    {
      Result result;
      result.representation = r;
      const BuiltScene scene(model, r, options.build);
      result.build = scene.report();
      std::vector<SurfaceHit> hits = traced(scene);
      countDisagreements(scene, hits, result);
      writePictures(scene, hits);
      if (options.speed)
        measure(grid, &scene, result);
      if (r.kind == RepresentationKind::Naive)
      {
        nearest = nearerHits(gridHits, hits);
        referenceHits = &nearest;
        comparison.reference = "the triangles of NAIVE and GRID, whichever is nearer";
      }
      result.errors = compareHits(*referenceHits, hits, footprint, scene.layout());
      comparison.results.push_back(result);
    }
    if (referenceHits != &gridHits)
      gridResult.errors = compareHits(*referenceHits, gridHits, footprint, grid.layout());
    if (options.speed && order.empty())
      measure(grid, nullptr, gridResult);
    for (int set = 0; set < numRaySets; set++)
      for (int query = 0; query < numQueries; query++)
        if (!gridSeconds[set][query].empty())
          gridResult.speed[set][query].mrays =
            double(sets[set].size()) * 1e-6 / median(gridSeconds[set][query]);
    /* In the order asked for; GRID, if only there to compare with, first. */
    std::vector<Result> ordered;
    if (!askedForGrid)
      ordered.push_back(gridResult);
    comparison.results.push_back(gridResult);
    for (const Representation& r : options.representations)
      for (const Result& result : comparison.results)
        if (result.representation.label() == r.label())
          ordered.push_back(result);
    comparison.results = std::move(ordered);
    return std::move(comparison);
  }

private:
  std::vector<SurfaceHit> traced(const BuiltScene& scene) const
  {
    Phase phase(scene.representation().label() + ": picture");
    return traceClosest(scene, primary, threads);
  }

  void makeRaySets(const BuiltScene& grid)
  {
    BounceSettings bounce;
    bounce.count = options.rays;
    bounce.offset = options.rayOffset * grid.bounds().diagonal();
    sets[Coherent] = coherentRays(primary, options.size, options.rays);
    sets[Incoherent] = bounceRays(primary, gridHits, bounce);
  }

  void describe(const Camera& camera)
  {
    comparison.model = model.name;
    comparison.faces = model.cage.numFaces();
    comparison.vertices = model.cage.positions.size();
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

  void countDisagreements(const BuiltScene& scene, const std::vector<SurfaceHit>& hits, Result& result) const
  {
    Phase phase(scene.representation().label() + ": any hit against closest hit");
    result.anyDisagreements[Coherent] = countAnyHitDisagreements(scene, primary, hits, threads);
    result.anyDisagreements[Incoherent] = countAnyHitDisagreements(
      scene, sets[Incoherent], traceClosest(scene, sets[Incoherent], threads), threads);
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
  }

  /* In turns with GRID, which goes first in every other round. */
  void measure(const BuiltScene& grid, const BuiltScene* scene, Result& result)
  {
    Phase phase(result.representation.label() + ": speed");
    const auto timeOne = [&](const BuiltScene& s, int set, int query) {
      return query == Closest ? timeClosest(s, sets[set]) : timeAny(s, sets[set]);
    };
    for (int set = 0; set < numRaySets; set++)
      for (int query = 0; query < numQueries; query++)
      {
        std::vector<double> own, base;
        for (int i = 0; i < options.repeat; i++)
        {
          if (scene && i % 2)
            own.push_back(timeOne(*scene, set, query));
          base.push_back(timeOne(grid, set, query));
          if (scene && i % 2 == 0)
            own.push_back(timeOne(*scene, set, query));
          phase.update(double((set * numQueries + query) * options.repeat + i + 1) /
                       double(numRaySets * numQueries * options.repeat));
        }
        gridSeconds[set][query].insert(gridSeconds[set][query].end(), base.begin(), base.end());
        if (scene)
        {
          result.speed[set][query].mrays = double(sets[set].size()) * 1e-6 / median(own);
          result.speed[set][query].toGrid = median(base) / median(own);
        }
      }
  }

  const Options& options;
  unsigned threads;
  Model model;
  float footprint = 0;
  std::vector<Ray> primary, sets[numRaySets];
  std::vector<SurfaceHit> gridHits, nearest;
  const std::vector<SurfaceHit>* referenceHits = nullptr;
  std::vector<double> gridSeconds[numRaySets][numQueries];
  Comparison comparison;
};

} // namespace

Comparison runComparison(const Options& options)
{
  return Run(options).run();
}

} // namespace cbvh
