// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "elevation.h"

#include <string>
#include <vector>

namespace cbvh {

struct Options
{
  ElevationSettings elevation;
  float cell = 30;            // distance between samples; all lengths are in the raster's unit
  float maxError = 0;         // spacing of the lattice on which vertices are stored, at most
  float lift = 0;             // height above the samples at which rays start
  int tile = 1000;            // quads along a side
  int azimuths = 16;          // directions per sample
  float accuracy = 0.1f;      // of horizons, in degrees
  std::vector<int> window;    // x0, y0, x1, y1 without x1 and y1
  int threads = 0;            // 0: all
  std::string output = "sky_view.tif";
  std::string embree;         // kernel of Embree; empty: compressed
};

/* Returns false after --help and --version, which have been printed then. Throws Error that names the option. */
bool parseOptions(Options& options, int argc, char** argv);

/* Sets the default window, and throws Error for one outside of the raster. */
void setWindow(Options& options, const Elevation& elevation);

} // namespace cbvh
