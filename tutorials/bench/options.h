// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Command line of cbvh_bench: lists whose combinations are measured. */

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
  std::vector<Representation> representations; // GRID is always built, even if not in this list
  std::vector<Library> libraries;              // at least one; if there are several, all have names
  std::vector<std::string> isas;
  std::string device = "cpu"; // that traces: "cpu", "vulkan", "ray-query", "vulkan:NAME" or "ray-query:NAME"
  std::vector<unsigned> threads; // for tracing
  std::vector<RaySet> sets;
  std::vector<Query> queries;
  std::vector<TraceMode> modes;
  int buildThreads = 0;      // 0 for all
  int referenceLevel = -1;   // level of GRID as a second reference for errors; -1 for none
  size_t trueHits = 20000;   // largest number of hits per view that are compared with the true surface
  size_t rays = 200000;      // largest number per set, 0 for one per pixel
  int repeat = 7;            // 0 to skip speed
  ImageSize size;
  float rayOffset = 1e-4f;   // of bounced rays, in diagonals of the bounding box
  uint32_t seed = 1;         // of bounced rays and of hits that are compared with the true surface
  Checks checks;
  Vec3f position;            // to which models are moved
  std::optional<float> maxError; // in diagonals of the cage's bounding box; 0: lossless cVERT; unset: the default
  std::string pictures;      // folder, empty for none
  int samples = 16;          // per pixel of shaded pictures
  std::vector<int> pictureLevels; // levels for which pictures are written; empty: all
  std::string json;          // file, empty for none
  std::string command;       // the command line; the program without its folder
};

/* Parses a command line. Returns nothing after printing help. Throws Error, one line, for anything invalid, before
 * anything is built. */
std::optional<BenchOptions> parseBenchOptions(int argc, char** argv, const Machine& machine);

} // namespace cbvh
