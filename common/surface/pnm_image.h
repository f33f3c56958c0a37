// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* PBM, PGM, PPM and PFM. OpenImageIO (2.4 to 3.1) divides samples of 16 bits by the file's maximum in integers, which
 * overflow above a maximum of 32768 and round down otherwise. */

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace programs {

/* Samples of one byte with a maximum of 255 stay bytes. All others are floats: integers are divided by the file's
 * maximum, which is the attribute `maximumAttribute`, and floats are multiplied by the magnitude of the file's scale.
 * Row 0 is the top. */
class PnmImage final : public OIIO::ImageInput {
public:
  static constexpr const char* maximumAttribute = "pnm:maximum";

  /* True if the file begins like one of these formats, whatever its extension. */
  static bool isPnm(const std::string& path);

  const char* format_name() const override { return "pnm"; }
  bool open(const std::string& path, OIIO::ImageSpec& spec) override;
  bool close() override;
  bool read_native_scanline(int subimage, int miplevel, int y, int z, void* data) override;

private:
  enum class Kind { Bits, Integers, Floats };

  bool fail(const std::string& reason);
  bool readHeader();
  bool readNumber(uint64_t& value);
  bool readScale();
  bool readText(bool isBits);
  bool readInteger(const unsigned char* row, size_t i, int y, unsigned& value);
  void skipBlanks();

  std::string file;
  std::string_view rest; // after the header: the raster
  std::string decoded;   // raster of a text file, as in a binary one
  Kind kind = Kind::Integers;
  unsigned most = 1;
  size_t rowBytes = 0;
  float scale = 1;
  bool isLittleEndian = false;
};

} // namespace programs
