// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A map as the texture system expects it: images of floats that fill their display windows.
 *
 * Corrects what OpenImageIO's readers or texture system (2.4) do not handle:
 * - Integers other than uint8 and uint16, and doubles, become floats, because the texture system asserts on them. As
 *   in OpenImageIO, unsigned integers become 0..1 and signed integers -1..1.
 * - The texture system wraps at the data window. Here an image is its display window, and texels outside of the data
 *   window are neutral.
 * - TIFF with white as zero is inverted for all unsigned types; OpenImageIO does so for 8 bits only.
 * - Samples of PGM and PPM are divided by the file's maximum, see pnm_image.h.
 * - Rip maps of OpenEXR are ignored.
 * - What OpenImageIO reads incorrectly without an error is rejected, see map_rejections.h.
 * - Missing texels become neutral: NaN, finite values up to -3.4e38, and the value of GDAL's tag. */

#include "surface/geo_tiff.h"

#include <OpenImageIO/imageio.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace programs {

/* Channels to read. */
struct ChannelRange {
  int first = 0;
  int count = 0;
  float neutral = 0.0f; // displaces nothing
};

class MapImage final : public OIIO::ImageInput {
public:
  /* Passes `range` to open(). If image i has an entry in firstChannels, it replaces range.first. */
  static OIIO::ImageSpec configuration(const ChannelRange& range, const std::vector<int>& firstChannels = {});

  void setChannelRange(const ChannelRange& r) { range = r; }

  /* True if the texture system can read the current image itself, unless texels are missing. */
  bool isTextureReadable() const { return textureReadable; }

  bool isCopyOrMask() const { return copyOrMask; }

  /* True if images of the file are independent pictures with their own channels. */
  bool hasParts() const { return source && std::string(source->format_name()) == "openexr"; }

  /* Name of the current part, or empty. */
  std::string partName() const { return std::string(m_spec.get_string_attribute("oiio:subimagename")); }

  /* Smaller edge of the file's tiles, or 0 without tiles. */
  int tileSize() const { return tile; }

  /* Value of a sample of the file that becomes 1. */
  float unit() const { return sampleUnit; }

  size_t numMissing() const { return missing; }

  /* Tags of GeoTIFF and GDAL of the current image; empty unless the file is a TIFF. */
  GeoTags geoTags() const;

  /* Reason not to read the current image, or empty. */
  const std::string& rejection() const { return rejectionText; }

  const char* format_name() const override { return "map"; }
  bool open(const std::string& path, OIIO::ImageSpec& spec) override { return open(path, spec, OIIO::ImageSpec()); }
  bool open(const std::string& path, OIIO::ImageSpec& spec, const OIIO::ImageSpec& config) override;
  bool close() override;
  int current_subimage() const override { return image; }
  bool seek_subimage(int subimage, int miplevel) override;
  bool read_native_scanline(int subimage, int miplevel, int y, int z, void* data) override {
    return read_native_scanlines(subimage, miplevel, y, y + 1, z, data);
  }
  bool read_native_scanlines(int subimage, int miplevel, int yBegin, int yEnd, int z, void* data) override;

private:
  bool openSource(const OIIO::ImageSpec& config);
  bool describe();
  std::optional<double> nodataOf(const OIIO::ImageSpec& from) const;
  bool readRows(int yBegin, int yEnd, std::vector<float>& rows);
  void replaceMissing(std::vector<float>& rows, const std::vector<char>& equalsNodata);

  std::unique_ptr<OIIO::ImageInput> source;
  std::string file;
  bool isRipMapped = false;
  std::vector<TiffPage> pages;    // of a TIFF
  std::vector<int> firstChannels; // per image, or empty
  ChannelRange range;
  std::string rejectionText;
  size_t missing = 0;

  int image = -1;
  OIIO::ROI window; // the visible part, in the source's coordinates
  std::optional<double> nodata;
  float sampleUnit = 1;
  int tile = 0;
  bool textureReadable = false, copyOrMask = false, isInverted = false, isFloating = false;
};

} // namespace programs
