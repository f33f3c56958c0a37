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
  bool still = false;
};

template<typename Run>
double secondsOf(const Run& run)
{
  const auto before = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

enum Query { Single, Packets, AnyHit };

/* Seconds; hits: of the rays. */
double trace(RTCScene scene, const std::vector<RTCRayHit>& rays, std::vector<RTCRayHit>& hits, Query query)
{
  hits = rays;
  if (query == Packets)
    return secondsOf([&] { PacketTracer(scene).intersect(hits.data(), hits.size()); });
  if (query == Single)
    return secondsOf([&] { EmbreeTracer(scene).intersect(hits.data(), hits.size()); });
  return secondsOf([&] {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (RTCRayHit& r : hits)
      rtcOccluded1(scene, &context, &r.ray);
  });
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

  RTCScene handle() const { return scene.get(); }

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

/* What is traced: a picture's rays, one by one and in tiles for packets, and what bounces off the surface, all at random times. */
struct RaySets
{
  RaySets(const Options& options, const Model& model, RTCScene scene) : camera(Camera::fit(model.positions(), 0.0f, model.view, 40, {options.side, options.side}))
  {
    const std::vector<Ray> rays = primaryRays(camera);
    primary = load(rays, 1);
    std::vector<RTCRayHit> hits;
    trace(scene, primary, hits, Single);
    std::vector<SurfaceHit> seen(rays.size());
    for (size_t i = 0; i < seen.size(); i++)
      if (isHit(hits[i]))
      {
        seen[i].t = hits[i].ray.tfar;
        seen[i].face = 0;
        seen[i].normal = {hits[i].hit.Ng_x, hits[i].hit.Ng_y, hits[i].hit.Ng_z};
      }
    BounceSettings bounce;
    bounce.offset = 1e-4f * model.cage.bounds().diagonal();
    bounces = load(bounceRays(rays, seen, bounce), 2);
    tiles = load(coherentRays(rays, camera.size(), 0), 3);
  }

  Camera camera;
  std::vector<RTCRayHit> primary, bounces, tiles;
};

constexpr int numQueries = 4; // single rays, bounces, any hit of these, packets

/* How many times as fast rays are in `ours` as in `theirs`, each query. */
void compareSpeeds(const RaySets& rays, RTCScene theirs, RTCScene ours, unsigned repeat, double speed[numQueries])
{
  const struct { const std::vector<RTCRayHit>& rays; Query query; } sets[numQueries] = {{rays.primary, Single}, {rays.bounces, Single}, {rays.bounces, AnyHit}, {rays.tiles, Packets}};
  const FastDenormals fast;
  std::vector<RTCRayHit> hits;
  for (int set = 0; set < numQueries; set++)
  {
    std::vector<double> ratios;
    for (unsigned i = 0; i < repeat; i++)
    {
      const double before = trace(theirs, sets[set].rays, hits, sets[set].query), now = trace(ours, sets[set].rays, hits, sets[set].query);
      ratios.push_back(before / now);
    }
    speed[set] = median(ratios);
  }
}

void measure(const Options& options, const Model& model)
{
  const Built grid(model, options, false, options.repeat), ours(model, options, true, options.repeat);
  const double quads = double(model.layout(options.level).numQuads());
  const RaySets rays(options, model, grid.handle());
  const std::vector<RTCRayHit>& timed = rays.primary;
  double speed[numQueries];
  compareSpeeds(rays, grid.handle(), ours.handle(), options.repeat, speed);
  std::vector<RTCRayHit> hits[2];
  /* errors in pixels of the picture */
  trace(grid.handle(), timed, hits[0], Single);
  trace(ours.handle(), timed, hits[1], Single);
  size_t lost = 0, both = 0, far = 0;
  double squares = 0;
  std::vector<float> errors;
  const float footprint = rays.camera.footprint();
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

/* One quad, small, beside all that stands in a box; it moves away from it. */
Model smallMovingModel(const Box3f& box)
{
  const float size = 0.02f * box.diagonal();
  const Vec3f corner = box.upper;
  Model model;
  model.cage.positions = {corner, corner + Vec3f{size, 0, 0}, corner + Vec3f{size, size, 0}, corner + Vec3f{0, size, 0}};
  model.cage.faceSizes = {4};
  model.cage.faceIndices = {0, 1, 2, 3};
  model.poses.resize(1);
  for (const Vec3f& p : model.cage.positions)
    model.poses[0].push_back(p + Vec3f{size, size, size});
  return model;
}

/* What a surface that stands still loses where its scene has another that moves. */
void measureStill(const Options& options, Model model)
{
  model.poses.clear();
  const Model other = smallMovingModel(model.cage.bounds());
  EmbreeDevice device(options.isa.empty() ? "" : "isa=" + options.isa);
  DisplacementContext contexts[2];
  contexts[0].displacement = model.displacement.get();
  contexts[0].level = contexts[1].level = options.level;
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_VERT;
  const GeometryHandle still = SharedTopology(device, model.cage).makeGeometry(Placement(), contexts[0], &args),
                       moving = SharedTopology(device, other.cage, other.poses).makeGeometry(Placement(), contexts[1], &args);
  const SceneHandle alone(rtcNewScene(device.handle())), both(rtcNewScene(device.handle()));
  rtcAttachGeometry(alone.get(), still.get());
  rtcAttachGeometry(both.get(), still.get());
  rtcAttachGeometry(both.get(), moving.get());
  rtcCommitScene(alone.get());
  rtcCommitScene(both.get());
  device.check("committing");
  double speed[numQueries];
  compareSpeeds(RaySets(options, model, alone.get()), alone.get(), both.get(), 3 * options.repeat, speed);
  std::printf("| %s | %.3f | %.3f | %.3f | %.3f |\n", model.name.c_str(), speed[0], speed[1], speed[2], speed[3]);
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
  app.add_flag("--still", options.still, "measure instead how many times as fast rays that meet a surface which stands still are where something else in its scene moves");
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
  if (options.still)
    std::printf("| a still surface | rays: single | bounces | any hit | packets |\n|:--|--:|--:|--:|--:|\n");
  else
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
    if (options.still)
    {
      measureStill(options, model);
      continue;
    }
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
