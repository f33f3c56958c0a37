// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* An elevation raster; each sample is a vertex. Keeps the rows in use in memory, or all rows of a repeated raster. */

#include "height_encoding.h"
#include "surface/geo_tiff.h"
#include "surface/map_image.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace programs {

struct ElevationSettings {
  std::string path;
  std::string channel; // name or number; empty: the raster's only channel
  HeightEncoding encoding = HeightEncoding::Plain;
  std::optional<float> nodata;  // missing samples of the file, in addition to NaN, -3.4e38 and GDAL's tag
  int repeatX = 1, repeatY = 1; // copies along x and y
  float noiseHeight = 0;        // of the largest features of the noise, in the raster's unit
};

class Elevation {
public:
  /* Reads the first image that is no smaller copy and no mask. Throws Error with the path. */
  explicit Elevation(const ElevationSettings& settings);

  /* Size in samples. Neighboring copies are mirrored and share a row or column, so there are no steps. */
  int width() const { return (sourceWidth - 1) * settings.repeatX + 1; }
  int height() const { return (sourceHeight - 1) * settings.repeatY + 1; }

  /* Heights of w x h samples from (x0,y0) on, by rows, in the raster's unit; NaN if missing. Row 0 is the top of the
   * image. Plain heights are multiplied by GDAL's scale, and its offset is added. Throws Error. */
  std::vector<float> heights(int x0, int y0, int w, int h, unsigned threads);

  /* Tags of a GeoTIFF of the samples from (x0,y0) on. Control points of a repeated raster are left out: they say
   * nothing about its copies. Empty if the raster is no GeoTIFF. */
  GeoTags geoTags(int x0, int y0) const;

private:
  void openPicture();
  void selectChannels(OIIO::TypeDesc type);
  void readRows(int begin, int end);
  void readChannels(int begin, int end, int firstChannel, int lastChannel, float* out);
  void decodeRows(int begin, int end, float* out);
  float noiseAt(int x, int y) const;

  const ElevationSettings settings;
  MapImage image;
  int picture = 0; // number of the image in its file
  int channel = 0; // of plain heights
  float unit = 1;  // of a file's sample, because MapImage maps integers to -1..1 or 0..1
  HeightScale scale;
  int sourceWidth = 0, sourceHeight = 0;
  int firstRow = 0;
  std::vector<float> rows; // from firstRow on
};

} // namespace programs
