// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Measures what surfaces take as clusters of formats for GPUs, and how many clusters these cannot hold. See --help. */

#include "basics/seconds.h"
#include "building/built_scene.h"
#include "building/subdivision_geometry.h"
#include "programs/command_line.h"
#include "programs/run_program.h"
#include "programs/surface_options.h"
#include "scenes/catalogue.h"
#include "support/cluster_judge.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore.h>
#include <embree3/rtcore_compressed_clusters.h>
#include <embree3/rtcore_compression.h>

#include <cstdio>
#include <string>
#include <vector>

namespace cbvh {
namespace {

struct Options
{
  std::vector<std::string> scenes{"cube", "trex", "frog", "scythe", "knee"};
  SceneSettings cage; // in their place, if it has a path
  int level = 6;
  float maxError = -1; // negative: the library's
  Vec3f away{0, 0, 0};
  float scale = 1;
  bool check = false;
};

const struct { RTCClusterFormat format; const char* name; } formats[] = {{RTC_CLUSTER_FORMAT_COMPRESSED1, "COMPRESSED1"}, {RTC_CLUSTER_FORMAT_DGF1, "DGF1"}};

/* "3 raw, 2 range", of clusters that are floats. */
std::string floatsOf(const RTCCompressedClusterReport& report)
{
  const char* const names[] = {"", "raw", "moving", "range"};
  std::string text;
  for (int reason = 1; reason < 4; reason++)
    if (report.numClustersOf[reason])
      text += (text.empty() ? "" : ", ") + std::to_string(report.numClustersOf[reason]) + " " + names[reason];
  return text.empty() ? "0" : text;
}

/* Returns how many vertices were decoded, each as often as clusters have it. */
size_t measure(const Options& options, Model& model)
{
  for (Vec3f& p : model.cage.positions)
    p = p * options.scale + options.away;
  EmbreeDevice device("");
  const SharedTopology topology(device, model.cage, {});
  DisplacementContext context;
  context.displacement = model.displacement.get();
  context.level = options.level;
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_VERT;
  if (options.maxError >= 0)
    args.maxError = options.maxError;
  const size_t before = device.memory().live();
  const GeometryHandle geometry = topology.makeGeometry(Placement(), context, &args);
  const SceneHandle scene(rtcNewScene(device.handle()));
  rtcAttachGeometry(scene.get(), geometry.get());
  rtcCommitScene(scene.get());
  device.check("committing");
  const double bytes = double(device.memory().live() - before);

  size_t decoded = 0;
  for (const auto& format : formats)
  {
    RTCCompressedClusterReport report;
    const double seconds = secondsOf([&] { rtcForEachCompressedCluster(geometry.get(), 0, format.format, nullptr, nullptr, &report); });
    device.check("cutting clusters");
    const double triangles = double(report.numTriangles);
    std::printf("| %s | %.2f | %.2f | %s | %zu | %.1f | %.2f | %.2f | %s | %.1f |", model.name.c_str(), triangles * 1e-6, bytes / triangles, format.name, report.numClusters,
                triangles / double(report.numClusters), double(report.bytes) / triangles, double(report.indexBytes) / triangles, floatsOf(report).c_str(), seconds);
    if (options.check)
    {
      const test::ClusterJudge judge(geometry.get(), 0, format.format);
      decoded += judge.decodedVertices;
      std::printf(" %zu vertices |", judge.decodedVertices);
    }
    std::printf("\n");
    std::fflush(stdout);
  }
  return decoded;
}

int run(int argc, char** argv)
{
  Options options;
  CLI::App app("Stores scenes as cVERT and cuts them into clusters of formats for GPUs: bytes a triangle, of vertices and of indices that are not those of a whole grid, and clusters that come as floats because the format cannot hold them.", "cbvh_clusters");
  app.add_option("--scene", options.scenes, "comma list of " + listOfScenes())->delimiter(',')->capture_default_str();
  app.add_option("--level", options.level, "of tessellation: faces have 2^L x 2^L quads")->capture_default_str();
  app.add_option("--max-error", options.maxError, "spacing of the lattice, 0: none, vertices stay [the library's]");
  app.add_option("--away", options.away.x, "moves scenes so far along x, and half of that along y");
  app.add_option("--scale", options.scale, "of the cage, before that; its displacement stays as it is")->capture_default_str();
  app.add_flag("--check", options.check, "decodes all clusters, as their specifications say, and compares triangles and vertices with those that rays hit");
  addMapOptions(app, options.cage);
  app.add_option("--cage", options.cage.cagePath, "a cage in place of scenes, OBJ")->type_name("FILE");
  if (!parseCommandLine(app, argc, argv))
    return 0;
  options.away.y = 0.5f * options.away.x;
  std::printf("| scene | million triangles | cVERT, bytes a triangle | as | clusters | triangles a cluster | bytes a triangle | and of indices | clusters that are floats | s |%s\n|:--|--:|--:|:--|--:|--:|--:|--:|--:|--:|%s\n",
              options.check ? " the same to the bit |" : "", options.check ? "--:|" : "");
  size_t decoded = 0;
  for (const std::string& scene : options.cage.cagePath.empty() ? options.scenes : std::vector<std::string>{""})
  {
    SceneSettings of = options.cage;
    of.scene = scene;
    std::string warnings;
    Model model = loadScene(withDefaultAmplitude(of), warnings);
    std::fputs(warnings.c_str(), stderr);
    decoded += measure(options, model);
  }
  if (options.check)
    std::printf("\n%zu vertices were decoded: each is the same to the bit, and so is each triangle.\n", decoded);
  return 0;
}

} // namespace
} // namespace cbvh

int main(int argc, char** argv)
{
  return cbvh::runProgram("cbvh_clusters", [=] { return cbvh::run(argc, argv); });
}
