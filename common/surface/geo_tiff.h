// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tags of GeoTIFF and GDAL, which OpenImageIO neither reads nor writes: where samples are on the Earth, which samples
 * are missing, and the unit of heights.
 * Based on: OGC GeoTIFF Standard 1.1, 2019; GDAL's documentation of its GTiff driver. */

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace programs {

/* Empty if the file lacks a tag. */
struct GeoTags {
  std::vector<double> pixelScale, tiepoints, matrix; // 33550, 33922, 34264: coordinates of columns and rows
  std::vector<uint16_t> keys;                        // 34735: the coordinate system
  std::vector<double> keyNumbers;                    // 34736: numbers that keys refer to
  std::string keyTexts;                              // 34737: texts that keys refer to
  std::string metadata;                              // 42112: GDAL's, as XML
  std::string nodata;                                // 42113: GDAL's value of missing samples
};

struct TiffPage {
  unsigned width = 0, height = 0;
  bool isCopyOrMask = false; // a smaller copy or a mask of another page
  GeoTags tags;
};

/* All pages of a TIFF or BigTIFF. Stops at the first malformed page. Returns nothing for other files, whose errors
 * OpenImageIO reports. Ignores tags whose type is not that of the standard. */
std::vector<TiffPage> readTiffPages(const std::string& path);

/* The first page that is no smaller copy and no mask, if there is one. */
std::optional<TiffPage> firstImage(const std::string& path);

/* --- place ------------------------------------------------------------------- */

/* Coordinates of samples, the centers of pixels: x = x0 + column * xOfColumn + row * xOfRow, and y as well. */
struct SamplePlaces {
  double x0 = 0, xOfColumn = 1, xOfRow = 0;
  double y0 = 0, yOfColumn = 0, yOfRow = -1;

  bool isRotated() const { return xOfRow != 0 || yOfColumn != 0; }
};

/* Empty without a transformation, also if the file has only control points. The precedence of tags is GDAL's. */
std::optional<SamplePlaces> samplePlaces(const GeoTags& tags);

/* Distance between samples in projected coordinates (not in degrees), if it is the same along columns and rows. */
std::optional<double> projectedCell(const GeoTags& tags);

/* Replaces the transformation of tags. Keeps whether it refers to the corners or to the centers of pixels. */
void setSamplePlaces(GeoTags& tags, const SamplePlaces& places);

/* The tags of a part of the raster that starts at a column and a row. */
GeoTags tagsOfPart(GeoTags tags, size_t column, size_t row);

/* --- heights -------------------------------------------------------------------- */

/* Height = offset + scale * sample. */
struct HeightScale {
  double scale = 1, offset = 0;

  bool isIdentity() const { return scale == 1 && offset == 0; }
};

/* Scale and offset of a channel in GDAL's metadata. Throws Error, without a path, if they are not numbers. */
HeightScale heightScale(const GeoTags& tags, int channel);

/* --- writing -------------------------------------------------------------------- */

enum class SampleKind { Unsigned, Signed, Floating };

/* By rows, all channels of a pixel together. */
struct RasterSamples {
  size_t width = 0, height = 0, channels = 1;
  SampleKind kind = SampleKind::Floating;
  unsigned bits = 32;
  const void* data = nullptr;
};

/* Writes a compressed TIFF, or a BigTIFF if it may exceed 4 GB, completely or not at all. NaN is the value of missing
 * samples if they are floats. Ignores tags.metadata and tags.nodata, which describe the samples of another raster.
 * Throws Error with the path. */
void writeGeoTiff(const std::string& path, const RasterSamples& samples, const GeoTags& tags);

} // namespace programs
