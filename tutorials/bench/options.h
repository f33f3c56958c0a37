// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Command line of cbvh_bench: lists, whose combinations are measured. */

#include "library.h"
#include "machine.h"
#include "robustness.h"
#include "building/representation.h"
#include "scenes/catalogue.h"
#include "tracing/camera.h"
#include "tracing/trace_timing.h"

#include <optional>
#include <string>
#include <vector>

namespace cbvh {

struct BenchScene
{
  std::string label;      // as on the command line: "cube", "cube:0.45", "herd-40"
  SceneSettings settings;
};

struct BenchOptions
{
  std::vector<BenchScene> scenes;
  std::vector<std::string> views;
  std::vector<int> levels;
  std::vector<Representation> representations; // GRID among them or not: it is always built
  std::vector<Library> libraries;              // at least one; of several all have names
  std::vector<std::string> isas;
  std::string device = "cpu";                  // that traces: "cpu", "vulkan", "ray-query", "vulkan:NAME" or "ray-query:NAME"
  std::vector<unsigned> threads;               // that trace
  std::vector<RaySet> sets;
  std::vector<Query> queries;
  std::vector<TraceMode> modes;
  int buildThreads = 0;      // 0 for all
  int referenceLevel = -1;   // GRID at this level is a second reference for errors; -1 for none
  size_t trueHits = 20000;   // at most, a view, that are compared with the true surface
  size_t rays = 200000;      // at most, a set, 0 for one a pixel
  int repeat = 7;            // 0: no speed
  ImageSize size;
  float rayOffset = 1e-4f;   // of bounced rays, in bounding-box diagonals
  uint32_t seed = 1;         // of bounced rays and of the hits compared with the true surface
  Checks checks;
  Vec3f position;            // that models are moved to
  std::optional<float> maxError; // in bounding-box diagonals; 0: lossless cVERT; none: as the library chooses
  std::string pictures;      // folder, empty for none
  int samples = 16;          // a pixel, of shaded pictures
  std::vector<int> pictureLevels; // levels that get pictures; empty: all
  std::string json;          // file, empty for none
  std::string command;       // the command line, program without its folder
};

/* Reads a command line. Returns nothing when it asked for help, which is printed.
 * Throws Error, one line, for anything wrong, before anything is built. */
std::optional<BenchOptions> parseBenchOptions(int argc, char** argv, const Machine& machine);

} // namespace cbvh
