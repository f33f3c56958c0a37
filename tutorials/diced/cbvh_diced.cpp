// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Measures what geometry costs that an application has diced, compressed and in Embree's own kernel of its type: bytes, commits, and
 * rays, which both trace in turns. See --help. */

#include "basics/vec.h"
#include "building/diced_surface.h"
#include "measure/quantiles.h"
#include "programs/run_program.h"
#include "programs/surface_options.h"
#include "scenes/catalogue.h"
#include "tracing/camera.h"
#include "tracing/ray_conversion.h"
#include "tracing/ray_sets.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cbvh {
namespace {

struct Options
{
  std::vector<std::string> scenes{"trex", "frog", "cube"};
  std::vector<std::string> inputs{"grids:4", "grids:8", "grids:16", "grids:64", "quads", "quads:rows", "quads:shuffled", "triangles"};
  int level = 6;
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

/* The same geometry in one of the two ways. */
class Built
{
public:
  using MakeGeometry = std::function<GeometryHandle(EmbreeDevice&)>;

  Built(const MakeGeometry& makeGeometry, const std::string& isa, bool compressed, unsigned repeat)
    : device(isa.empty() ? "" : "isa=" + isa)
  {
    for (unsigned i = 0; i < repeat; i++)
    {
      scene.reset();
      const size_t empty = device.memory().live();
      GeometryHandle geometry = makeGeometry(device);
      inputBytes = device.memory().live() - empty;
      RTCCompressionArguments args;
      rtcInitCompressionArguments(&args);
      args.compression = compressed ? RTC_COMPRESSION_VERT : RTC_COMPRESSION_NONE;
      rtcSetGeometryCompression(geometry.get(), &args);
      const size_t before = device.memory().live();
      device.memory().resetPeak();
      seconds.push_back(secondsOf([&] {
        rtcCommitGeometry(geometry.get());
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

  /* Seconds; hits: of the rays. */
  double trace(const std::vector<RTCRayHit>& rays, std::vector<RTCRayHit>& hits, bool packets) const
  {
    hits = rays;
    if (packets)
      return secondsOf([&] { PacketTracer(scene.get()).intersect(hits.data(), hits.size()); });
    return secondsOf([&] { EmbreeTracer(scene.get()).intersect(hits.data(), hits.size()); });
  }

private:
  EmbreeDevice device;
  SceneHandle scene; // released before its device

public:
  std::vector<double> seconds; // of commits
  size_t inputBytes = 0;       // the application's buffers
  size_t bytes = 0, peak = 0;  // besides these
  RTCCompressionStatistics statistics{};
};

std::vector<RTCRayHit> load(const std::vector<Ray>& rays)
{
  std::vector<RTCRayHit> loaded(rays.size());
  for (size_t i = 0; i < rays.size(); i++)
    load(rays[i], loaded[i]);
  return loaded;
}

/* Whether two say the same of a ray, but for rounding and what the lattice moves. */
bool agree(const RTCRayHit& a, const RTCRayHit& b, float distance)
{
  return a.hit.geomID == b.hit.geomID && (a.hit.geomID == RTC_INVALID_GEOMETRY_ID || std::abs(a.ray.tfar - b.ray.tfar) <= distance);
}

void measure(const Options& options, const Model& model, const DicedSurface& surface, const DicedInput& input)
{
  const bool isIndexed = input.shape != DicedInput::Grids;
  const QuadMesh mesh = isIndexed ? surface.mesh(input.order) : QuadMesh();
  const auto makeGeometry = [&](EmbreeDevice& device) {
    return isIndexed ? makeIndexed(device, mesh, input.shape == DicedInput::Triangles) : surface.makeGrids(device, input.gridQuads);
  };
  const Built embree(makeGeometry, options.isa, false, options.repeat), ours(makeGeometry, options.isa, true, options.repeat);
  const Camera camera = Camera::fit(model.positions(), 0.0f, model.view, 40, {options.side, options.side});
  const std::vector<Ray> primary = primaryRays(camera);
  std::vector<RTCRayHit> hits[2];
  embree.trace(load(primary), hits[0], false);
  std::vector<SurfaceHit> seen(primary.size());
  for (size_t i = 0; i < seen.size(); i++)
    if (hits[0][i].hit.geomID != RTC_INVALID_GEOMETRY_ID)
    {
      seen[i].t = hits[0][i].ray.tfar;
      seen[i].face = 0;
      seen[i].normal = {hits[0][i].hit.Ng_x, hits[0][i].hit.Ng_y, hits[0][i].hit.Ng_z};
    }
  BounceSettings bounce;
  bounce.offset = 1e-4f * model.cage.bounds().diagonal();
  const std::vector<RTCRayHit> sets[3] = {load(primary), load(coherentRays(primary, camera.size(), 0)), load(bounceRays(primary, seen, bounce))};
  double speed[3];
  size_t disagreements = 0, rays = 0;
  const FastDenormals fast;
  for (int set = 0; set < 3; set++)
  {
    std::vector<double> ratios;
    for (unsigned i = 0; i < options.repeat; i++)
    {
      const bool packets = set == 1;
      const double theirs = embree.trace(sets[set], hits[0], packets), mine = ours.trace(sets[set], hits[1], packets);
      ratios.push_back(theirs / mine);
    }
    speed[set] = median(ratios);
    for (size_t i = 0; i < sets[set].size(); i++) disagreements += !agree(hits[0][i], hits[1][i], 1e-3f * model.cage.bounds().diagonal());
    rays += sets[set].size();
  }
  const double quads = double(surface.numQuads()), inputBytes = double(ours.inputBytes) / quads;
  const RTCCompressionStatistics& s = ours.statistics;
  std::printf("| %s | %s | %.2f | %.1f | %.2f | %.2f | %.2f | %.3f | %.3f | %.2f | %.2f | %.2f | %.2f | %.4f |\n", model.name.c_str(), input.name.c_str(), quads * 1e-6,
              double(embree.bytes) / quads, double(ours.bytes) / quads, double(ours.peak) / quads, inputBytes, median(embree.seconds), median(ours.seconds),
              median(ours.seconds) / median(embree.seconds), speed[0], speed[1], speed[2], 100.0 * double(disagreements) / double(rays));
  if (s.numRawBlocks || s.numQuads != surface.numQuads() || s.numLooseQuads)
    std::printf("  (%zu of %zu blocks are raw, %zu quads in blocks, %zu of them loose)\n", s.numRawBlocks, s.numBlocks, s.numQuads, s.numLooseQuads);
  std::fflush(stdout);
}

int run(int argc, char** argv)
{
  Options options;
  CLI::App app("Compares diced geometry, compressed, with Embree's own kernels of its type: bytes a quad besides the application's buffers, "
               "seconds of commits, how many times as fast rays are, and how many of 100 hit elsewhere, by a thousandth of the cage's diagonal.");
  app.add_option("--scene", options.scenes, "comma list of " + listOfScenes())->delimiter(',')->capture_default_str();
  app.add_option("--input", options.inputs, "comma list of how they are handed over: grids of a patch each, grids:N of N x N quads, quads and triangles as OpenSubdiv refines them, and these with :rows or :shuffled")->delimiter(',')->capture_default_str();
  app.add_option("--level", options.level, "of tessellation: faces have 2^L x 2^L quads")->capture_default_str();
  app.add_option("--repeat", options.repeat, "runs, of which the median is shown")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--size", options.side, "pixels along a side of the picture whose rays are traced")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--isa", options.isa, "widest instruction set, as Embree names it [the host's best]");
  SceneSettings cage;
  addMapOptions(app, cage);
  app.add_option("--cage,--mesh", cage.cagePath, "a cage in place of scenes, OBJ")->type_name("FILE");
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::ParseError& error)
  {
    return app.exit(error);
  }
  std::vector<DicedInput> inputs;
  for (const std::string& word : options.inputs)
    inputs.push_back(DicedInput::parse(word));
  if (!cage.cagePath.empty())
    options.scenes = {""};
  std::printf("| scene | input | million quads | Embree, bytes | cVERT | peak | input | Embree, s | cVERT | ratio | rays: single | packets | bounces | others, %% |\n"
              "|:--|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  BuildSettings settings;
  settings.level = options.level;
  for (const std::string& scene : options.scenes)
  {
    SceneSettings of = cage;
    of.scene = scene;
    std::string warnings;
    const Model model = loadScene(withStrength(of), warnings);
    std::fputs(warnings.c_str(), stderr);
    validateBuild(settings);
    const DicedSurface surface(model, settings);
    for (const DicedInput& input : inputs)
      measure(options, model, surface, input);
  }
  return 0;
}

} // namespace
} // namespace cbvh

int main(int argc, char** argv)
{
  return cbvh::runProgram("cbvh_diced", [=] { return cbvh::run(argc, argv); });
}
