// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures/joined_picture.h"
#include "basics/error.h"
#include "basics/image_file.h"
#include "basics/input_files.h"

#include <OpenImageIO/imageio.h>

#include <memory>

namespace programs {
namespace {

std::string sizeText(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

constexpr const char* unassociated = "oiio:UnassociatedAlpha"; // otherwise OpenImageIO multiplies colors by alpha

/* The parts read so far. */
struct Rows {
  OIIO::ImageSpec spec; // of the first part; its height is that of all parts
  std::vector<unsigned char> bytes;
};

void requireSameKind(const OIIO::ImageSpec& first, const OIIO::ImageSpec& part, const std::string& path) {
  if (part.width != first.width)
    throw Error(path + ": has " + std::to_string(part.width) + " columns: expected " + std::to_string(first.width) +
                ", as the first part");
  if (part.channelnames != first.channelnames || part.format != first.format ||
      part.channelformats != first.channelformats)
    throw Error(path + ": has other channels than the first part");
  if (part.full_height != first.full_height && part.full_height != part.height)
    throw Error(path + ": is a part of a picture of " + std::to_string(part.full_height) + " rows: expected " +
                std::to_string(first.full_height) + ", as the first part");
}

void append(const std::string& path, Rows& rows) {
  recordInputFile(path);
  OIIO::ImageSpec config;
  config.attribute(unassociated, 1);
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path, &config);
  if (!input) throw Error(path + ": cannot be read: " + OIIO::geterror());
  const OIIO::ImageSpec part = input->spec();
  if (part.width != part.full_width && part.full_width > 0)
    throw Error(path + ": has " + std::to_string(part.width) + " of " + std::to_string(part.full_width) +
                " columns: expected whole rows");
  const bool isFirst = rows.bytes.empty();
  if (isFirst) rows.spec = part;
  else requireSameKind(rows.spec, part, path);
  const bool isPlaced = part.full_height != part.height;
  const int expected = isFirst ? part.full_y : rows.spec.y + rows.spec.height;
  if (isPlaced && part.y != expected)
    throw Error(path + ": begins at row " + std::to_string(part.y - part.full_y) + ": expected row " +
                std::to_string(expected - part.full_y) + ", after the part before");
  const size_t begin = rows.bytes.size();
  rows.bytes.resize(begin + part.image_bytes(true));
  /* For truncated files, some readers fill in the rest and only leave a message. */
  if (!input->read_image(0, 0, 0, -1, OIIO::TypeUnknown, rows.bytes.data() + begin) || input->has_error())
    throw Error(path + ": cannot be read: " + input->geterror());
  if (!isFirst) rows.spec.height += part.height;
}

} // namespace

void joinPictures(const std::vector<std::string>& parts, std::optional<ImageSize> size, const std::string& path) {
  requireImageFormat(path);
  Rows rows;
  for (const std::string& part : parts) append(part, rows);
  requireNoInputFile(path);
  OIIO::ImageSpec& spec = rows.spec;
  const bool isPlaced = spec.full_height > spec.height;
  if (isPlaced)
    throw Error(parts.back() + ": ends at row " + std::to_string(spec.y - spec.full_y + spec.height) + " of " +
                std::to_string(spec.full_height) + ": expected all rows");
  spec.full_height = spec.height;
  if (size && (spec.width != size->width || spec.height != size->height))
    throw Error("the parts have " + sizeText(spec.width, spec.height) + " pixels: expected " +
                sizeText(size->width, size->height));
  spec.attribute(unassociated, 1);
  writeImageFile(path, spec, OIIO::TypeUnknown, rows.bytes.data());
}

} // namespace programs
