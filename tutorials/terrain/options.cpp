// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "programs/command_line.h"

namespace cbvh {

bool parseOptions(Options& options, int argc, char** argv)
{
  CLI::App app("Computes the sky-view factor of each sample of an elevation raster. Traces horizons through the "
               "compressed terrain. All lengths have the unit of the raster's heights.", "cbvh_terrain");
  app.add_option("raster", options.elevation.path,
      "elevation raster that OpenImageIO reads: 16-bit, signed or float")->type_name("FILE")->required();
  app.add_option("-o,--output", options.output,
      "sky-view factors: float in TIFF or EXR, 16-bit in PNG")->type_name("FILE")->capture_default_str();
  app.add_option("--cell", options.cell, "distance between samples")->capture_default_str();
  app.add_option("--nodata", options.elevation.nodata,
      "height of missing samples, in addition to NaN and GDAL's tag");
  app.add_option("--repeat", options.elevation.repeat,
      "N or N,M: copies of the raster along x and y, each mirrored")->expected(1, 2)->delimiter(',');
  app.add_option("--noise-height", options.elevation.noiseHeight,
      "height of noise that makes copies differ [4 cells, 0 without --repeat]");
  app.add_option("--window", options.window,
      "x0,y0,x1,y1: part to compute, columns x0 to x1-1 and rows y0 to y1-1 [all]")->expected(4)->delimiter(',');
  app.add_option("--azimuths", options.azimuths, "directions per sample")
      ->capture_default_str()->check(CLI::Range(1, 3600));
  app.add_option("--accuracy", options.accuracy,
      "accuracy of horizons in degrees")->capture_default_str()->check(CLI::Range(0.001, 10.0));
  app.add_option("--max-error", options.maxError,
      "largest spacing of the lattice on which vertices are stored [1/128 of a cell]");
  app.add_option("--start-height", options.startHeight,
      "height above the samples at which rays start [1/64 of a cell]");
  app.add_option("--tile", options.tile, "quads per side of a tile")
      ->capture_default_str()->check(CLI::Range(16, 16000));
  app.add_option("--threads", options.threads, "number of threads, 0 for all")
      ->capture_default_str()->check(CLI::Range(0, 1024));
  app.add_option("--embree", options.embree,
      "trace an uncompressed terrain with this kernel of Embree instead")
      ->check(CLI::IsMember({"grid", "quad", "triangle"}));
  if (!parseCommandLine(app, argc, argv))
    return false;
  requireNotNegative("--noise-height", options.elevation.noiseHeight);
  requireNotNegative("--max-error", options.maxError);
  requireNotNegative("--start-height", options.startHeight);
  if (!(options.cell > 0) || !std::isfinite(options.cell))
    throw Error("invalid --cell " + shortNumber(options.cell) + ": expected a finite length above 0");
  if (options.maxError == 0)
    options.maxError = options.cell / 128;
  if (options.startHeight == 0)
    options.startHeight = options.cell / 64;
  if (app.count("--repeat") && !app.count("--noise-height"))
    options.elevation.noiseHeight = 4 * options.cell;
  return true;
}

void setWindow(Options& options, const Elevation& elevation)
{
  std::vector<int>& window = options.window;
  if (window.empty())
    window = {0, 0, elevation.width(), elevation.height()};
  if (window[0] < 0 || window[1] < 0 || window[2] <= window[0] || window[3] <= window[1]
      || window[2] > elevation.width() || window[3] > elevation.height())
    throw Error("invalid --window: expected a part of 0,0," + std::to_string(elevation.width()) + "," +
                std::to_string(elevation.height()));
}

} // namespace cbvh
