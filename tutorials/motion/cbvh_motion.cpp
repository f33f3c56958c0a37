// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Measures what surfaces that move cost, compressed and by GRID with motion blur: bytes, commits, rays at random times, which both
 * trace in turns, and how far hits are apart. See --help. */

#include "basics/vec.h"
#include "building/subdivision_geometry.h"
#include "measure/quantiles.h"
#include "programs/run_program.h"
#include "programs/surface_options.h"
#include "scenes/catalogue.h"
#include "scenes/motion.h"
#include "tracing/camera.h"
#include "tracing/ray_conversion.h"
#include "tracing/ray_sets.h"
#include "building/scene_tracer.h"
#include "building/built_scene.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace cbvh {
namespace {

struct Options
{
  std::vector<std::string> scenes{"trex", "frog", "cube"};
  std::vector<std::string> motions = motionNames();
  int level = 6;
  int steps = 2;
  float degrees = 30;
  unsigned repeat = 5;
  int side = 512; // of the picture whose rays are traced
  std::string isa;
};

template<typename Run>
double secondsOf(const Run& run)
{
  const auto before = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

/* The same surface in one of the two ways. */
class Built
{
public:
  Built(const Model& model, const Options& options, bool compressed, unsigned repeat)
    : device(std::string(options.isa.empty() ? "" : "isa=" + options.isa)), topology(device, model.cage, model.poses)
  {
    context.displacement = model.displacement.get();
    context.level = options.level;
    for (unsigned i = 0; i < repeat; i++)
    {
      scene.reset();
      RTCCompressionArguments args;
      rtcInitCompressionArguments(&args);
      args.compression = compressed ? RTC_COMPRESSION_VERT : RTC_COMPRESSION_NONE;
      const size_t before = device.memory().live();
      device.memory().resetPeak();
      seconds.push_back(secondsOf([&] {
        const GeometryHandle geometry = topology.makeGeometry(Placement(), context, &args);
        scene.reset(rtcNewScene(device.handle()));
        rtcAttachGeometry(scene.get(), geometry.get());
        rtcCommitScene(scene.get());
      }));
      device.check("committing");
      bytes = device.memory().live() - before;
      peak = device.memory().peak() - before;
    }
    rtcGetSceneCompressionStatistics(scene.get(), &statistics);
    device.check("asking for statistics");
  }

  enum Query { Single, Packets, AnyHit };

  /* Seconds; hits: of the rays. */
  double trace(const std::vector<RTCRayHit>& rays, std::vector<RTCRayHit>& hits, Query query) const
  {
    hits = rays;
    if (query == Packets)
      return secondsOf([&] { PacketTracer(scene.get()).intersect(hits.data(), hits.size()); });
    if (query == Single)
      return secondsOf([&] { EmbreeTracer(scene.get()).intersect(hits.data(), hits.size()); });
    return secondsOf([&] {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      for (RTCRayHit& r : hits)
        rtcOccluded1(scene.get(), &context, &r.ray);
    });
  }

private:
  EmbreeDevice device;
  SharedTopology topology;
  DisplacementContext context;
  SceneHandle scene; // released before its device

public:
  std::vector<double> seconds; // of commits
  size_t bytes = 0, peak = 0;
  RTCCompressionStatistics statistics{};
};

std::vector<RTCRayHit> load(const std::vector<Ray>& rays, uint32_t seed)
{
  std::mt19937 random(seed);
  std::vector<RTCRayHit> loaded(rays.size());
  for (size_t i = 0; i < rays.size(); i++)
  {
    load(rays[i], loaded[i]);
    loaded[i].ray.time = float(random() >> 8) * 0x1p-24f;
  }
  return loaded;
}

bool isHit(const RTCRayHit& r) { return r.hit.geomID != RTC_INVALID_GEOMETRY_ID; }

void measure(const Options& options, const Model& model)
{
  const Built grid(model, options, false, options.repeat), ours(model, options, true, options.repeat);
  const double quads = double(model.layout(options.level).numQuads());
  const Camera camera = Camera::fit(model.positions(), 0.0f, model.view, 40, {options.side, options.side});
  const std::vector<Ray> primary = primaryRays(camera);
  std::vector<RTCRayHit> hits[2];
  const std::vector<RTCRayHit> timed = load(primary, 1);
  grid.trace(timed, hits[0], Built::Single);
  std::vector<SurfaceHit> seen(primary.size());
  for (size_t i = 0; i < seen.size(); i++)
    if (isHit(hits[0][i]))
    {
      seen[i].t = hits[0][i].ray.tfar;
      seen[i].face = 0;
      seen[i].normal = {hits[0][i].hit.Ng_x, hits[0][i].hit.Ng_y, hits[0][i].hit.Ng_z};
    }
  BounceSettings bounce;
  bounce.offset = 1e-4f * model.cage.bounds().diagonal();
  const std::vector<RTCRayHit> bounces = load(bounceRays(primary, seen, bounce), 2), tiles = load(coherentRays(primary, camera.size(), 0), 3);
  const struct { const std::vector<RTCRayHit>& rays; Built::Query query; } sets[] = {{timed, Built::Single}, {bounces, Built::Single}, {bounces, Built::AnyHit}, {tiles, Built::Packets}};
  double speed[4];
  const FastDenormals fast;
  for (int set = 0; set < 4; set++)
  {
    std::vector<double> ratios;
    for (unsigned i = 0; i < options.repeat; i++)
    {
      const double theirs = grid.trace(sets[set].rays, hits[0], sets[set].query), mine = ours.trace(sets[set].rays, hits[1], sets[set].query);
      ratios.push_back(theirs / mine);
    }
    speed[set] = median(ratios);
  }
  /* errors in pixels of the picture */
  grid.trace(timed, hits[0], Built::Single);
  ours.trace(timed, hits[1], Built::Single);
  size_t lost = 0, both = 0, far = 0;
  double squares = 0;
  std::vector<float> errors;
  const float footprint = camera.footprint();
  for (size_t i = 0; i < timed.size(); i++)
  {
    if (isHit(hits[0][i]) != isHit(hits[1][i])) { lost++; continue; }
    if (!isHit(hits[0][i])) continue;
    both++;
    const double error = std::abs(double(hits[0][i].ray.tfar) - hits[1][i].ray.tfar) / (footprint * hits[0][i].ray.tfar);
    if (error > 5) { far++; continue; }
    squares += error * error;
    errors.push_back(float(error));
  }
  const RTCCompressionStatistics& s = ours.statistics;
  std::printf("| %s | %.2f | %.1f | %.2f | %.2f | %.2f | %.3f | %.3f | %.2f | %.2f | %.2f | %.2f | %.2f | %.4f | %.3f | %.1f |\n", model.name.c_str(), quads * 1e-6,
              double(grid.bytes) / quads, double(ours.bytes) / quads, double(s.motionBytes) / quads / double(model.poses.size()), double(ours.peak) / double(ours.bytes), median(grid.seconds), median(ours.seconds),
              median(ours.seconds) / median(grid.seconds), speed[0], speed[1], speed[2], speed[3], std::sqrt(squares / double(std::max<size_t>(1, errors.size()))),
              quantile(errors, 0.99), 1e4 * double(lost + far) / double(both));
  std::printf("  (top level %.2f, frames %.2f, nodes %.2f, leaves %.2f; %zu of %zu blocks are raw)\n", double(s.topLevelBytes) / quads, double(s.frameBytes) / quads, double(s.nodeBytes) / quads, double(s.leafBytes) / quads, s.numRawBlocks, s.numBlocks);
  std::fflush(stdout);
}

int run(int argc, char** argv)
{
  Options options;
  CLI::App app("Compares surfaces that move, compressed, with GRID's motion blur: bytes a quad, seconds of commits, how many times as fast rays at random times are, and, "
               "along primary rays, RMSE and p99 of distances within 5 pixels, and false hits, misses and farther ones of 10,000.");
  app.add_option("--scene", options.scenes, "comma list of " + listOfScenes())->delimiter(',')->capture_default_str();
  app.add_option("--motion", options.motions, "comma list of how they move: turn, bend, twist, walk")->delimiter(',')->capture_default_str();
  app.add_option("--steps", options.steps, "in time")->capture_default_str();
  app.add_option("--degrees", options.degrees, "from the first step to the last")->capture_default_str();
  app.add_option("--level", options.level, "of tessellation: faces have 2^L x 2^L quads")->capture_default_str();
  app.add_option("--repeat", options.repeat, "runs, of which the median is shown")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--size", options.side, "pixels along a side of the picture whose rays are traced")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--isa", options.isa, "widest instruction set, as Embree names it [the host's best]");
  SceneSettings cage;
  addMapOptions(app, cage);
  app.add_option("--cage", cage.cagePath, "a cage in place of scenes, OBJ")->type_name("FILE");
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::ParseError& error)
  {
    return app.exit(error);
  }
  if (!cage.cagePath.empty())
    options.scenes = {""};
  std::printf("| scene | million quads | GRID, bytes | cVERT | a further step | peak | GRID, s | cVERT | ratio | rays: single | bounces | any hit | packets | RMSE, px | p99 | others of 10,000 |\n"
              "|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (const std::string& scene : options.scenes)
  {
    SceneSettings of = cage;
    of.scene = scene;
    std::string warnings;
    Model model = loadScene(withStrength(of), warnings);
    std::fputs(warnings.c_str(), stderr);
    const std::string name = model.name;
    for (const std::string& motion : options.motions)
    {
      MotionSettings settings;
      settings.name = motion;
      settings.steps = options.steps;
      settings.degrees = options.degrees;
      addMotion(model, settings);
      model.name = name + ", " + motion;
      measure(options, model);
    }
  }
  return 0;
}

} // namespace
} // namespace cbvh

int main(int argc, char** argv)
{
  return cbvh::runProgram("cbvh_motion", [=] { return cbvh::run(argc, argv); });
}
