// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares compressed moving surfaces with GRID: memory, commits, rays at random times, traced alternately, and
 * distances between hits. */

#include "building/built_scene.h"
#include "building/subdivision_geometry.h"
#include "measure/interleaved_speed.h"
#include "measure/quantiles.h"
#include "programs/command_line.h"
#include "programs/compared_scenes.h"
#include "programs/run_program.h"
#include "timed_build.h"
#include "scenes/motion.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace programs { namespace {

struct Options {
  ComparedScenes compared;
  std::vector<std::string> motions = motionNames();
  int steps = 2;
  float degrees = 30;
  bool staticSurface = false;
};

constexpr int numQueries = 4; // single rays, bounces, any hit of bounces, packets

void compareSpeeds(const PictureRays& rays, RTCScene theirs, RTCScene ours, unsigned repeat, double speed[numQueries]) {
  const struct {
    const std::vector<RTCRayHit>& rays;
    TimedQuery query;
  } sets[numQueries] = {{rays.primary, TimedQuery::Single},
                        {rays.bounces, TimedQuery::Single},
                        {rays.bounces, TimedQuery::AnyHit},
                        {rays.tiles, TimedQuery::Packets}};
  const FlushDenormals fast;
  std::vector<RTCRayHit> hits[2];
  for (int set = 0; set < numQueries; set++)
    speed[set] = medianSpeedup(theirs, ours, sets[set].rays, sets[set].query, repeat, hits);
}

/* form: RTC_COMPRESSION_CTILE or RTC_COMPRESSION_CVERT. */
void measure(const Options& options, const Model& model, const TimedBuild& grid, RTCCompression form) {
  const TimedBuild ours(prepareCage(model, options.compared.level), options.compared, form);
  const double quads = double(model.layout(options.compared.level).numQuads());
  const PictureRays rays(model, grid.handle(), options.compared.size, true);
  const std::vector<RTCRayHit>& timed = rays.primary;
  double speed[numQueries];
  compareSpeeds(rays, grid.handle(), ours.handle(), options.compared.repeat, speed);
  std::vector<RTCRayHit> hits[2];
  traceTimed(grid.handle(), timed, hits[0], TimedQuery::Single);
  traceTimed(ours.handle(), timed, hits[1], TimedQuery::Single);
  size_t lost = 0, both = 0, far = 0;
  double squares = 0;
  std::vector<float> errors; // in pixels
  const float footprint = rays.camera.footprint();
  for (size_t i = 0; i < timed.size(); i++) {
    if (isHit(hits[0][i]) != isHit(hits[1][i])) {
      lost++;
      continue;
    }
    if (!isHit(hits[0][i])) continue;
    both++;
    const double distance = std::abs(double(hits[0][i].ray.tfar) - hits[1][i].ray.tfar);
    const double error = distance / (footprint * hits[0][i].ray.tfar);
    if (error > 5) {
      far++;
      continue;
    }
    squares += error * error;
    errors.push_back(float(error));
  }
  const RTCCompressionStatistics& s = ours.statistics;
  std::printf(
      "| %s | %s | %.2f | %.1f | %.2f | %.2f | %.2f | %.3f | %.3f | %.2f | %.2f | %.2f | %.2f | %.2f | %.4f | %.3f "
      "| %.1f |\n",
      model.name.c_str(), form == RTC_COMPRESSION_CTILE ? "cTILE" : "cVERT", quads * 1e-6, double(grid.bytes) / quads,
      double(ours.bytes) / quads, double(s.motionBytes) / quads / double(model.poses.size()),
      double(ours.peak) / double(ours.bytes), median(grid.seconds), median(ours.seconds),
      median(ours.seconds) / median(grid.seconds), speed[0], speed[1], speed[2], speed[3],
      std::sqrt(squares / double(std::max<size_t>(1, errors.size()))), quantile(errors, 0.99),
      1e4 * double(lost + far) / double(both));
  std::printf("  (top level %.2f, frames %.2f, nodes %.2f, leaves %.2f; %zu of %zu blocks are raw)\n",
              double(s.topLevelBytes) / quads, double(s.headerBytes) / quads, double(s.nodeBytes) / quads,
              double(s.leafBytes) / quads, s.numRawBlocks, s.numBlocks);
  std::fflush(stdout);
}

/* A small quad that moves away from a box. */
Model smallMovingModel(const Box3f& box) {
  const float size = 0.02f * box.diagonal();
  const Vec3f corner = box.upper;
  Model model;
  model.cage.positions = {corner, corner + Vec3f{size, 0, 0}, corner + Vec3f{size, size, 0},
                          corner + Vec3f{0, size, 0}};
  model.cage.faceSizes = {4};
  model.cage.faceIndices = {0, 1, 2, 3};
  model.poses.resize(1);
  for (const Vec3f& p : model.cage.positions) model.poses[0].push_back(p + Vec3f{size, size, size});
  return model;
}

/* The relative speed of rays of a static surface if something else in its scene moves. */
void measureStatic(const Options& options, Model model) {
  model.poses.clear();
  const Model other = smallMovingModel(model.cage.bounds());
  EmbreeDevice device(options.compared.deviceConfig());
  DisplacementContext contexts[2];
  contexts[0].displacement = model.displacement.get();
  contexts[0].level = contexts[1].level = options.compared.level;
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_CVERT;
  const GeometryHandle fixed = SharedTopology(device, model.cage).makeGeometry(Placement(), contexts[0], &args);
  const GeometryHandle moving =
      SharedTopology(device, other.cage, other.poses).makeGeometry(Placement(), contexts[1], &args);
  const SceneHandle alone(rtcNewScene(device.handle())), both(rtcNewScene(device.handle()));
  rtcAttachGeometry(alone.get(), fixed.get());
  rtcAttachGeometry(both.get(), fixed.get());
  rtcAttachGeometry(both.get(), moving.get());
  rtcCommitScene(alone.get());
  rtcCommitScene(both.get());
  device.check("committing");
  double speed[numQueries];
  const PictureRays rays(model, alone.get(), options.compared.size, true);
  compareSpeeds(rays, alone.get(), both.get(), 3 * options.compared.repeat, speed);
  std::printf("| %s | %.3f | %.3f | %.3f | %.3f |\n", model.name.c_str(), speed[0], speed[1], speed[2], speed[3]);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Compares compressed moving surfaces in both forms with GRID's motion blur. Prints bytes per quad, seconds of "
      "commits, the relative speed of rays at random times, and errors along primary rays: RMSE and p99 of "
      "distances up to 5 pixels, and the number of false hits, misses and larger distances per 10,000 hits.",
      "cbvh_motion");
  options.compared.addOptions(app);
  app.add_option("--motion", options.motions, "comma-separated list of motions: turn, bend, twist, walk")
      ->type_name("LIST")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--steps", options.steps, "number of time steps")->type_name("N")->capture_default_str();
  app.add_option("--degrees", options.degrees, "angle from the first time step to the last")
      ->type_name("ANGLE")
      ->capture_default_str();
  app.add_flag("--static", options.staticSurface,
               "measure instead the relative speed of rays of a static surface if something else in its scene moves");
  if (!parseCommandLine(app, argc, argv)) return 0;
  options.compared.validate();
  for (const std::string& motion : options.motions) validateMotion({motion, options.steps});
  if (options.staticSurface)
    std::printf("| static surface | rays: single | bounces | any hit | packets |\n|:--|--:|--:|--:|--:|\n");
  else
    std::printf(
        "| scene | form | million quads | GRID, bytes | ours | per further step | peak | GRID, s | ours | ratio | "
        "rays: single | bounces | any hit | packets | RMSE, px | p99 | others of 10,000 |\n"
        "|:--|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  options.compared.forEach([&](Model& model) {
    if (options.staticSurface) return measureStatic(options, model);
    const std::string name = model.name;
    for (const std::string& motion : options.motions) {
      MotionSettings settings;
      settings.name = motion;
      settings.steps = options.steps;
      settings.degrees = options.degrees;
      addMotion(model, settings);
      model.name = name + ", " + motion;
      const TimedBuild grid(prepareCage(model, options.compared.level), options.compared, RTC_COMPRESSION_NONE);
      for (RTCCompression form : {RTC_COMPRESSION_CTILE, RTC_COMPRESSION_CVERT}) measure(options, model, grid, form);
    }
  });
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_motion", [=] { return programs::run(argc, argv); });
}
