// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "basics/image_file.h"
#include "programs/command_line.h"
#include "programs/outputs.h"
#include "surface/geo_tiff.h"

#include <filesystem>
#include <optional>

namespace programs {
namespace {

void parseCopies(const std::string& text, ElevationSettings& elevation) {
  constexpr float most = 1e6f;
  const Vec2f copies = parseRepeat(text);
  if (copies.x > most || copies.y > most || std::round(copies.x) != copies.x || std::round(copies.y) != copies.y)
    throw Error("invalid --height-repeat '" + text + "': expected whole numbers from 1 to 1000000");
  elevation.repeatX = int(copies.x);
  elevation.repeatY = int(copies.y);
}

HeightEncoding parseEncoding(const std::string& text) {
  if (text == "terrarium") return HeightEncoding::Terrarium;
  if (text == "mapbox") return HeightEncoding::Mapbox;
  throw Error("invalid --encoding '" + text + "': expected terrarium or mapbox");
}

/* Of a GeoTIFF in projected coordinates. */
std::optional<double> cellOf(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};
  const std::optional<TiffPage> page = firstImage(path);
  return page ? projectedCell(page->tags) : std::nullopt;
}

} // namespace

bool parseOptions(Options& options, int argc, char** argv) {
  std::string repeat, encoding;
  CLI::App app("Computes the sky-view factor of each sample of an elevation raster. Traces horizons through the "
               "compressed terrain. All lengths have the unit of the raster's heights.",
               "cbvh_terrain");
  app.add_option("raster", options.elevation.path, "elevation raster that OpenImageIO reads: 16-bit, signed or float")
      ->type_name("FILE")
      ->required();
  app.add_option("--output", options.output,
                 "sky-view factors: float in TIFF or EXR, 16-bit in PNG; a TIFF gets the "
                 "georeference of a GeoTIFF")
      ->type_name("FILE")
      ->capture_default_str();
  app.add_option("--cell", options.cell, "distance between samples [of a GeoTIFF in projected coordinates, else 30]");
  app.add_option("--channel", options.elevation.channel, "name or number of the channel of heights [the only one]")
      ->type_name("NAME|N");
  app.add_option("--encoding", encoding,
                 "decode heights in meters from the colors of map tiles: terrarium, or mapbox for Mapbox's "
                 "Terrain-RGB; samples "
                 "whose alpha is 0 are missing")
      ->type_name("terrarium|mapbox");
  app.add_option("--nodata", options.elevation.nodata,
                 "missing samples of the file, in addition to NaN and GDAL's tag");
  app.add_option("--height-repeat", repeat, "copies of the raster, every other one mirrored; N, or columns x rows [1]")
      ->type_name("N|NxM");
  app.add_option("--noise-height", options.elevation.noiseHeight,
                 "height of noise that makes copies differ [4 cells, 0 without --height-repeat]");
  app.add_option("--crop", options.crop, "x0,y0,x1,y1: part to compute, columns x0 to x1-1 and rows y0 to y1-1 [all]")
      ->expected(4)
      ->delimiter(',');
  app.add_option("--azimuths", options.azimuths, "directions per sample")
      ->capture_default_str()
      ->check(CLI::Range(1, 3600));
  app.add_option("--accuracy", options.accuracy, "accuracy of horizons in degrees, 0.001 to 10")->capture_default_str();
  app.add_option("--max-error", options.maxError,
                 "largest spacing of the lattice on which heights are stored, 0 for lossless [1/128 of a cell]");
  app.add_option("--start-height", options.startHeight,
                 "height above the stored surface at which rays start [1/64 of a cell]");
  app.add_option("--tile", options.tile, "quads per side of a tile")
      ->capture_default_str()
      ->check(CLI::Range(16, 16000));
  app.add_option("--threads", options.threads, "number of threads, 0 for all")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  app.add_option("--embree", options.embree, "trace an uncompressed terrain with this kernel of Embree instead")
      ->check(CLI::IsMember({"grid", "quad", "triangle"}));
  if (!parseCommandLine(app, argc, argv)) return false;
  requireNotNegative("--noise-height", options.elevation.noiseHeight);
  requireNotNegative("--max-error", options.maxError);
  requireNotNegative("--start-height", options.startHeight);
  if (!app.count("--cell")) options.cell = float(cellOf(options.elevation.path).value_or(options.cell));
  if (!(options.cell > 0) || !std::isfinite(options.cell))
    throw Error("invalid --cell " + shortNumber(options.cell) + ": expected a finite length above 0");
  if (!(options.accuracy >= 0.001f && options.accuracy <= 10.0f))
    throw Error("invalid --accuracy " + shortNumber(options.accuracy) + ": expected 0.001 to 10 degrees");
  if (options.output.empty()) throw Error("invalid --output '': expected the name of a file");
  requireImageFormat(options.output);
  requireWritable({{"--output", options.output}});
  if (!app.count("--max-error")) options.maxError = options.cell / 128;
  if (!app.count("--start-height")) options.startHeight = options.cell / 64;
  if (app.count("--encoding")) options.elevation.encoding = parseEncoding(encoding);
  if (app.count("--encoding") && app.count("--channel"))
    throw Error("invalid --channel '" + options.elevation.channel +
                "': expected none with --encoding, which reads "
                "red, green and blue");
  if (app.count("--height-repeat")) parseCopies(repeat, options.elevation);
  if (app.count("--height-repeat") && !app.count("--noise-height")) options.elevation.noiseHeight = 4 * options.cell;
  return true;
}

void setCrop(Options& options, const Elevation& elevation) {
  std::vector<int>& crop = options.crop;
  if (crop.empty()) crop = {0, 0, elevation.width(), elevation.height()};
  if (crop[0] < 0 || crop[1] < 0 || crop[2] <= crop[0] || crop[3] <= crop[1] || crop[2] > elevation.width() ||
      crop[3] > elevation.height())
    throw Error("invalid --crop " + std::to_string(crop[0]) + "," + std::to_string(crop[1]) + "," +
                std::to_string(crop[2]) + "," + std::to_string(crop[3]) + ": expected a part of 0,0," +
                std::to_string(elevation.width()) + "," + std::to_string(elevation.height()) +
                " with x0 < x1 and y0 < y1");
}

} // namespace programs
