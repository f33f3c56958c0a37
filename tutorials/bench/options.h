// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

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

namespace programs {

struct BenchScene {
  std::string label; // "cube", "cube:0.45", "herd-40"
  SceneSettings settings;
};

struct BenchOptions {
  std::vector<BenchScene> scenes;
  std::vector<std::string> views;
  std::vector<int> levels;
  std::vector<Representation> representations; // GRID is always built
  std::vector<Library> libraries;              // at least one; several have names
  std::vector<std::string> isas;
  std::string device = "cpu"; // tracing device, see BuildSettings
  std::vector<unsigned> threads;
  std::vector<RaySet> sets;
  std::vector<Query> queries;
  std::vector<TraceMode> modes;
  int buildThreads = 0;    // 0 for all
  int referenceLevel = -1; // of GRID as a second reference for errors; -1 for none
  size_t trueHits = 20000; // per view, to compare with the true surface
  size_t rays = 200000;    // per set, 0 for one per pixel
  int repeat = 7;          // 0 to skip speed
  ImageSize size;
  float rayOffset = 1e-4f; // of bounced rays, in diagonals of the bounding box
  uint32_t seed = 1;       // of bounced rays, hits for the true surface, and checks
  Checks checks;
  Vec3f position;                 // of the models
  std::optional<float> maxError;  // in diagonals of the cage's bounding box; 0: lossless cVERT; unset: the default
  std::string pictures;           // folder, empty for none
  int samples = 16;               // per pixel of shaded pictures
  std::vector<int> pictureLevels; // empty: all
  std::string json;               // file, empty for none
  std::string command;            // program without its folder, and arguments
};

/* Returns nothing after --help, --version and --about, once their output is printed. Throws Error, one line, before
 * anything is built. */
std::optional<BenchOptions> parseBenchOptions(int argc, char** argv, const Machine& machine);

} // namespace programs
