// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "elevation.h"

#include <string>
#include <vector>

namespace programs {

struct Options {
  ElevationSettings elevation;
  float cell = 30;       // distance between samples, in the raster's unit, as all lengths
  float maxError = 0;    // largest spacing of the lattice of heights, 0 for lossless
  float startHeight = 0; // of rays above the stored surface
  int tile = 1000;       // quads per side of a tile
  int azimuths = 16;     // directions per sample
  float accuracy = 0.1f; // of horizons, in degrees
  std::vector<int> crop; // x0, y0, x1, y1: columns x0 to x1-1, rows y0 to y1-1
  int threads = 0;       // 0 for all
  std::string output = "sky_view.tif";
  std::string embree; // Embree's kernel; empty for compressed terrain
};

/* Returns false after --help and --version, once their output is printed. Throws Error with the option. */
bool parseOptions(Options& options, int argc, char** argv);

/* Default: the whole raster. Throws Error for a part outside of it. */
void setCrop(Options& options, const Elevation& elevation);

} // namespace programs
