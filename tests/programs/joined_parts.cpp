// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Joins parts of a picture by their data windows and compares the result with the whole picture bit by bit: all
 * channels of OpenEXR files, and the PNGs with the same base names.
 *
 * usage: joined_parts WHOLE.exr PART.exr... */

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct File {
  OIIO::ImageSpec spec;
  std::vector<char> bytes; // as stored

  explicit File(const std::string& path) {
    const auto input = OIIO::ImageInput::open(path);
    if (!input) throw std::runtime_error(path + ": " + OIIO::geterror());
    spec = input->spec();
    bytes.resize(spec.image_bytes(true));
    if (!input->read_image(0, 0, 0, -1, OIIO::TypeDesc::UNKNOWN, bytes.data()))
      throw std::runtime_error(path + ": " + input->geterror());
  }
};

void fail(const std::string& what) { throw std::runtime_error(what); }

/* Copies a part into the whole picture. x, y: position of its first pixel. seen: number of writes per pixel. */
void paste(File& whole, const File& part, int x, int y, std::vector<int>& seen) {
  const size_t pixel = whole.spec.pixel_bytes(true);
  if (part.spec.pixel_bytes(true) != pixel) fail("the channels of a part differ from the whole picture");
  for (int row = 0; row < part.spec.height; row++) {
    const size_t at = size_t(y + row) * whole.spec.width + x;
    std::memcpy(&whole.bytes[at * pixel], &part.bytes[size_t(row) * part.spec.width * pixel], part.spec.width * pixel);
    for (int i = 0; i < part.spec.width; i++) seen[at + i]++;
  }
}

std::string pngOf(const std::string& exr) { return exr.substr(0, exr.size() - 3) + "png"; }

void compare(int argc, char** argv) {
  const File whole(argv[1]), wholePng(pngOf(argv[1]));
  File joined = whole, joinedPng = wholePng;
  joined.bytes.assign(joined.bytes.size(), 0x55);
  joinedPng.bytes.assign(joinedPng.bytes.size(), 0x55);
  std::vector<int> seen(size_t(whole.spec.width) * whole.spec.height), seenPng = seen;
  for (int i = 2; i < argc; i++) {
    const File part(argv[i]), png(pngOf(argv[i]));
    if (part.spec.full_x != 0 || part.spec.full_y != 0 || part.spec.full_width != whole.spec.width ||
        part.spec.full_height != whole.spec.height)
      fail(std::string(argv[i]) + ": the display window differs from the whole picture");
    if (png.spec.width != part.spec.width || png.spec.height != part.spec.height)
      fail(std::string(argv[i]) + ": its PNG has a different size");
    paste(joined, part, part.spec.x, part.spec.y, seen);
    paste(joinedPng, png, part.spec.x, part.spec.y, seenPng);
  }
  for (int count : seen)
    if (count != 1) fail("the parts overlap or leave gaps");
  if (joined.bytes != whole.bytes) fail("OpenEXR: the parts differ from the whole picture");
  if (joinedPng.bytes != wholePng.bytes) fail("PNG: the parts differ from the whole picture");
}

} // namespace

int main(int argc, char** argv) try {
  if (argc < 3) fail("usage: joined_parts WHOLE.exr PART.exr...");
  compare(argc, argv);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "joined_parts: %s\n", e.what());
  return 1;
}
