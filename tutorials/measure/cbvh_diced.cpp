// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares compressed diced geometry with Embree's own kernel: memory, time of commits, and speed of rays, which are
 * traced alternately. */

#include "building/diced_surface.h"
#include "measure/interleaved_speed.h"
#include "measure/quantiles.h"
#include "programs/command_line.h"
#include "programs/compared_scenes.h"
#include "programs/run_program.h"
#include "timed_build.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <cstdio>
#include <string>
#include <vector>

namespace programs { namespace {

struct Options {
  ComparedScenes compared;
  std::vector<std::string> inputs{"grids:4", "grids:8",    "grids:16",       "grids:64",
                                  "quads",   "quads:rows", "quads:shuffled", "triangles"};
  bool compact = false;
};

/* True if both miss, or both hit at distances that differ by at most `distance`. */
bool agree(const RTCRayHit& a, const RTCRayHit& b, float distance) {
  return a.hit.geomID == b.hit.geomID &&
         (a.hit.geomID == RTC_INVALID_GEOMETRY_ID || std::abs(a.ray.tfar - b.ray.tfar) <= distance);
}

void measure(const Options& options, const Model& model, const DicedSurface& surface, const DicedInput& input) {
  const bool isIndexed = input.shape != DicedInput::Grids;
  const QuadMesh mesh = isIndexed ? surface.mesh(input.order) : QuadMesh();
  const auto prepare = [&](EmbreeDevice& device) {
    return commitOf(isIndexed ? makeIndexedGeometry(device, mesh, input.shape == DicedInput::Triangles)
                              : surface.makeGrids(device, input.gridQuads));
  };
  const TimedBuild embree(prepare, options.compared, RTC_COMPRESSION_NONE, -1,
                          options.compact ? RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_NONE);
  const TimedBuild ours(prepare, options.compared, RTC_COMPRESSION_CVERT);
  const PictureRays picture(model, embree.handle(), options.compared.size, false);
  const std::vector<RTCRayHit>* const sets[3] = {&picture.primary, &picture.tiles, &picture.bounces};
  std::vector<RTCRayHit> hits[2];
  double speedup[3];
  size_t disagreements = 0, rays = 0;
  const FlushDenormals denormals;
  for (int set = 0; set < 3; set++) {
    const TimedQuery query = set == 1 ? TimedQuery::Packets : TimedQuery::Single;
    speedup[set] = medianSpeedup(embree.handle(), ours.handle(), *sets[set], query, options.compared.repeat, hits);
    const float tolerance = 1e-3f * model.cage.bounds().diagonal();
    for (size_t i = 0; i < sets[set]->size(); i++) disagreements += !agree(hits[0][i], hits[1][i], tolerance);
    rays += sets[set]->size();
  }
  const double quads = double(surface.numQuads());
  const RTCCompressionStatistics& s = ours.statistics;
  std::printf("| %s | %s | %.2f | %.1f | %.2f | %.2f | %.2f | %.3f | %.3f | %.2f | %.2f | %.2f | %.2f | %.4f |\n",
              model.name.c_str(), input.name.c_str(), quads * 1e-6, double(embree.bytes) / quads,
              double(ours.bytes) / quads, double(ours.peak) / quads, double(ours.inputBytes) / quads,
              median(embree.seconds), median(ours.seconds), median(ours.seconds) / median(embree.seconds), speedup[0],
              speedup[1], speedup[2], 100.0 * double(disagreements) / double(rays));
  if (s.numRawBlocks || s.numQuads != surface.numQuads() || s.numIrregularQuads)
    std::printf("  (%s, %s: %zu of %zu quads are compressed, %zu of them in no grid of at least 4 x 4 quads; %zu of "
                "%zu blocks store floats)\n",
                model.name.c_str(), input.name.c_str(), s.numQuads, surface.numQuads(), s.numIrregularQuads,
                s.numRawBlocks, s.numBlocks);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Compares compressed diced geometry with Embree's own kernel of its type. Prints bytes per quad (after "
               "the commit, at its peak, both without the application's buffers, and of these buffers), seconds of "
               "commits and their ratio, the speed of rays in multiples of Embree's, and the percentage of rays that "
               "hit in only one of the scenes, or at distances that differ by more than a thousandth of the cage's "
               "diagonal.",
               "cbvh_diced");
  options.compared.addOptions(app);
  app.add_option("--input", options.inputs,
                 "comma-separated list of inputs: grids (one per patch), grids:N (N x N quads), quads or triangles in "
                 "the order of OpenSubdiv's refinement, the last two also with :rows (patch by patch, row by row) or "
                 ":shuffled (random order)")
      ->type_name("LIST")
      ->delimiter(',')
      ->capture_default_str();
  app.add_flag("--compact", options.compact,
               "compare with Embree's compact mode (RTC_SCENE_FLAG_COMPACT): less memory, slower rays");
  if (!parseCommandLine(app, argc, argv)) return 0;
  options.compared.validate();
  std::vector<DicedInput> inputs;
  for (const std::string& word : options.inputs) inputs.push_back(DicedInput::parse(word));
  std::printf("| scene | input | million quads | Embree, bytes | cVERT | peak | input | Embree, s | cVERT | ratio | "
              "rays: single | packets | bounces | different, %% |\n"
              "|:--|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  BuildSettings settings;
  settings.level = options.compared.level;
  options.compared.forEach([&](const Model& model) {
    const DicedSurface surface(model, settings);
    for (const DicedInput& input : inputs) measure(options, model, surface, input);
  });
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_diced", [=] { return programs::run(argc, argv); });
}
