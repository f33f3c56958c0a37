// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Measures surfaces as clusters of GPU formats, and counts clusters that do not fit these formats. */

#include "basics/seconds.h"
#include "building/built_scene.h"
#include "building/subdivision_geometry.h"
#include "building/surface_handles.h"
#include "programs/command_line.h"
#include "programs/run_program.h"
#include "programs/surface_options.h"
#include "programs/view_options.h"
#include "scenes/catalogue.h"
#include "support/cluster_judge.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace programs { namespace {

struct Options {
  std::vector<std::string> scenes{"cube", "trex", "frog", "scythe", "knee"};
  SceneSettings cage; // replaces the scenes if it has a path
  int level = 6;
  std::optional<float> maxError;
  Vec3f position{0, 0, 0};
  float scale = 1;
  bool verify = false;
};

const struct {
  CbvhClusterFormat format;
  const char* name;
} formats[] = {{CBVH_CLUSTER_FORMAT_COMPRESSED1, "COMPRESSED1"}, {CBVH_CLUSTER_FORMAT_DGF1, "DGF1"}};

/* Clusters stored as floats, by reason: "3 floats, 2 out of range". */
std::string describeFloatClusters(const CbvhClusterStatistics& statistics) {
  const char* const names[] = {"", "floats", "moving", "out of range"};
  std::string text;
  for (int reason = 1; reason < 4; reason++)
    if (statistics.numClustersByReason[reason])
      text += (text.empty() ? "" : ", ") + std::to_string(statistics.numClustersByReason[reason]) + " " + names[reason];
  return text.empty() ? "0" : text;
}

/* Prints a row per format. Returns the number of decoded vertices, counted once per cluster. */
size_t measure(const Options& options, Model& model) {
  for (Vec3f& p : model.cage.positions) p = p * options.scale + options.position;
  EmbreeDevice device("");
  const SharedTopology topology(device, model.cage, {});
  DisplacementContext context;
  context.displacement = model.displacement.get();
  context.level = options.level;
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_CVERT;
  if (options.maxError) args.maxError = *options.maxError;
  const size_t before = device.memory().live();
  const GeometryHandle geometry = topology.makeGeometry(Placement(), context, &args);
  const SceneHandle scene(rtcNewScene(device.handle()));
  rtcAttachGeometry(scene.get(), geometry.get());
  rtcCommitScene(scene.get());
  device.check("committing");
  const double bytes = double(device.memory().live() - before);

  const SurfaceHandle surface = surfaceOf(geometry.get());
  size_t decoded = 0;
  for (const auto& format : formats) {
    CbvhClusterStatistics statistics;
    const double seconds =
        secondsOf([&] { cbvhForEachCluster(surface.get(), 0, format.format, nullptr, nullptr, &statistics); });
    device.check("making clusters");
    if (statistics.numTriangles == 0)
      throw Error(model.name + ": no triangle is compressed: expected vertices in the range of floats");
    const double triangles = double(statistics.numTriangles);
    std::printf("| %s | %.2f | %.2f | %s | %zu | %.1f | %.2f | %.2f | %s | %.1f |", model.name.c_str(),
                triangles * 1e-6, bytes / triangles, format.name, statistics.numClusters,
                triangles / double(statistics.numClusters), double(statistics.bytes) / triangles,
                double(statistics.indexBytes) / triangles, describeFloatClusters(statistics).c_str(), seconds);
    if (options.verify) {
      const test::ClusterJudge judge(geometry.get(), 0, format.format);
      decoded += judge.decodedVertices;
      std::printf(" %zu vertices |", judge.decodedVertices);
    }
    std::printf("\n");
    std::fflush(stdout);
  }
  return decoded;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Stores scenes as cVERT and converts them to clusters of formats for GPUs. Prints bytes per triangle, "
               "bytes of indices per triangle (whole grids need none), and the number of clusters that are stored as "
               "floats because the format cannot hold them.",
               "cbvh_clusters");
  app.add_option("--scene", options.scenes, "comma-separated list of " + listOfScenes())
      ->type_name("LIST")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--level", options.level, "tessellation level L: each face has 2^L x 2^L quads")
      ->type_name("L")
      ->capture_default_str();
  app.add_option("--max-error", options.maxError,
                 "largest spacing of the lattice, 0 for lossless [the library's default]")
      ->type_name("E");
  app.add_option_function<std::string>(
         "--position", [&](const std::string& text) { options.position = parsePosition(text); },
         "position to which scenes are moved: x,y,z")
      ->type_name("P");
  app.add_option("--scale", options.scale, "factor of the cage before it is moved; the displacement is not scaled")
      ->type_name("S")
      ->capture_default_str();
  app.add_flag("--verify", options.verify,
               "decode all clusters by their specifications, and compare triangles and vertices with hits of rays");
  addMapOptions(app, options.cage);
  app.add_option("--cage", options.cage.cagePath, "control cage (OBJ) instead of scenes")->type_name("FILE");
  if (!parseCommandLine(app, argc, argv)) return 0;
  if (options.maxError) requireNotNegative("--max-error", *options.maxError);
  if (!(options.scale > 0) || !std::isfinite(options.scale))
    throw Error("invalid --scale " + shortNumber(options.scale) + ": expected a finite number above 0");
  BuildSettings build;
  build.level = options.level;
  validateBuild(build);
  std::printf("| scene | million triangles | cVERT, bytes per triangle | format | clusters | triangles per cluster | "
              "bytes per triangle | of indices | clusters as floats | s |%s\n"
              "|:--|--:|--:|:--|--:|--:|--:|--:|--:|--:|%s\n",
              options.verify ? " identical |" : "", options.verify ? "--:|" : "");
  size_t decoded = 0;
  for (const std::string& scene : options.cage.cagePath.empty() ? options.scenes : std::vector<std::string>{""}) {
    SceneSettings settings = options.cage;
    settings.scene = scene;
    std::string warnings;
    Model model = loadScene(withDefaultAmplitude(settings), warnings);
    std::fputs(warnings.c_str(), stderr);
    decoded += measure(options, model);
  }
  if (options.verify) std::printf("\nAll %zu decoded vertices and all triangles are identical to the bit.\n", decoded);
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_clusters", [=] { return programs::run(argc, argv); });
}
