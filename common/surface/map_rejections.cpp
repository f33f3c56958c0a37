// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/map_rejections.h"

#include <algorithm>
#include <cstdint>
#include <fstream>

namespace programs {
namespace {

constexpr size_t boxHeader = 8;

uint64_t bigEndian(const std::string& bytes, size_t at, size_t count) {
  uint64_t value = 0;
  for (size_t i = at; i < at + count && i < bytes.size(); i++) value = value << 8 | uint8_t(bytes[i]);
  return value;
}

std::string readAt(std::ifstream& file, uint64_t at, size_t count) {
  std::string bytes(count, '\0');
  file.clear();
  file.seekg(std::streamoff(at));
  file.read(bytes.data(), std::streamsize(count));
  bytes.resize(size_t(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

/* Returns the position of the codestream: the file's start, or the content of the box "jp2c". */
uint64_t codestreamOf(std::ifstream& file) {
  uint64_t at = 0;
  for (std::string box = readAt(file, at, 16); box.size() > boxHeader; box = readAt(file, at, 16)) {
    if (bigEndian(box, 0, 2) == 0xFF4F) return at;
    const uint64_t shortLength = bigEndian(box, 0, 4), length = shortLength == 1 ? bigEndian(box, 8, 8) : shortLength;
    if (box.compare(4, 4, "jp2c") == 0) return at + (shortLength == 1 ? 16 : boxHeader);
    if (length < boxHeader) break;
    at += length;
  }
  return at;
}

/* Reads the image and tile sizes of JPEG 2000 (ITU-T T.800, A.5.1). OpenImageIO offsets signed samples by the wrong
 * amount, and applies the origin of the reference grid twice, which reads beyond the image. */
std::string rejectionOfJpeg2000(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  constexpr size_t origin = 16, numComponents = 40, components = 42, maxComponents = 16384;
  const std::string start = readAt(file, codestreamOf(file), components + 3 * maxComponents);
  if (start.size() < components || bigEndian(start, 0, 4) != 0xFF4FFF51) return ""; // OpenImageIO reports the error
  for (size_t i = 0; i < bigEndian(start, numComponents, 2); i++)
    if (bigEndian(start, components + 3 * i, 1) & 0x80)
      return "it is a JPEG 2000 image with signed samples, which OpenImageIO does not read correctly: expected "
             "unsigned samples, or TIFF";
  if (bigEndian(start, origin, 4) || bigEndian(start, origin + 4, 4))
    return "it is a JPEG 2000 image whose origin is " + std::to_string(bigEndian(start, origin, 4)) + "," +
           std::to_string(bigEndian(start, origin + 4, 4)) +
           ", which OpenImageIO does not read correctly: expected 0,0, or TIFF";
  return "";
}

/* True if a channel of this Softimage PIC file is stored without run lengths. */
bool isUncompressedSoftimage(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  constexpr uint64_t firstPacket = 104;
  bool isChained = true;
  for (uint64_t at = firstPacket; isChained; at += 4) {
    const std::string packet = readAt(file, at, 4); // whether another one follows, bits, encoding, channels
    if (packet.size() < 4) return false;
    if (packet[2] == 0) return true;
    isChained = packet[0] != 0;
  }
  return false;
}

} // namespace

bool isUnsigned(OIIO::TypeDesc type) {
  return type == OIIO::TypeDesc::UINT8 || type == OIIO::TypeDesc::UINT16 || type == OIIO::TypeDesc::UINT32;
}

std::string rejectionOf(OIIO::ImageInput& source, const std::string& path, bool isInverted) {
  const OIIO::ImageSpec& spec = source.spec();
  const std::string format = source.format_name();
  if (format == "null")
    return "OpenImageIO makes up images for its extension and does not read the file: expected another extension";
  if (spec.deep) return "it is a deep image: expected one value per texel and channel";
  if (spec.width < 1 || spec.height < 1) return "it is empty: expected at least one texel";
  if (spec.depth > 1) return "it is a volume of " + std::to_string(spec.depth) + " slices: expected one";
  if (isInverted && !isUnsigned(spec.format))
    return "white is zero in it, which is undefined for samples of type " + std::string(spec.format.c_str()) +
           ": expected black as zero";
  /* OpenImageIO 2.4 reports success without filling the buffer. */
  if (format == "tiff" && spec.format == OIIO::TypeDesc::DOUBLE && spec.tile_width)
    return "it has tiles of type double, which OpenImageIO does not read: expected strips, or type float";
  if (format == "tiff" && spec.get_int_attribute("oiio:BitsPerSample") == 24)
    return "it has integers of 24 bits, whose bytes OpenImageIO reads in reverse order: expected 8, 16 or 32 bits";
  if (format == "fits")
    return "it is a FITS file, whose rows OpenImageIO reads one too late and whose scale it ignores: expected another "
           "format, such as TIFF";
  if (format == "webp" && spec.alpha_channel >= 0)
    return "it is a WebP image with alpha, by which OpenImageIO multiplies the other channels: expected an image "
           "without alpha, or PNG";
  const int orientation = spec.get_int_attribute("Orientation", 1);
  if ((format == "hdr" || format == "dpx" || format == "cineon") && orientation != 1)
    return "its rows or columns are in reverse order (orientation " + std::to_string(orientation) +
           "), which OpenImageIO ignores: expected rows from the top to the bottom, and columns from left to right";
  if (format == "softimage" && OIIO::openimageio_version() < 30000 && isUncompressedSoftimage(path))
    return "it is an uncompressed Softimage picture, which this version of OpenImageIO reads as zeros: expected run "
           "lengths, or another format, such as TIFF";
  if (format == "jpeg2000") return rejectionOfJpeg2000(path);
  return "";
}

} // namespace programs
