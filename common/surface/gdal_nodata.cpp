// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Based on: TIFF, Revision 6.0, Adobe, 1992, and its extension BigTIFF. */

#include "surface/gdal_nodata.h"

#include <cstdint>
#include <fstream>
#include <set>

namespace programs {
namespace {

constexpr unsigned nodataTag = 42113, asciiType = 2;
constexpr uint64_t longestText = 64; // bytes of a number

class TiffReader {
public:
  explicit TiffReader(const std::string& path) : file(path, std::ios::binary) {}

  std::vector<std::string> run() {
    std::vector<std::string> pages;
    std::set<uint64_t> known; // ends the loop if a malformed file repeats a page
    uint64_t directory = readHeader();
    while (directory != 0 && known.insert(directory).second) {
      std::string text;
      directory = readDirectory(directory, text);
      if (!file) break;
      pages.push_back(text);
    }
    return pages;
  }

private:
  std::string readBytes(size_t n) {
    std::string bytes(n, '\0');
    file.read(bytes.data(), std::streamsize(n));
    return bytes;
  }

  uint64_t readNumber(unsigned size) {
    const std::string bytes = readBytes(size);
    uint64_t value = 0;
    for (unsigned i = 0; i < size; i++) value = value << 8 | uint8_t(bytes[isBigEndian ? i : size - 1 - i]);
    return value;
  }

  /* Offset of the first directory, or 0. */
  uint64_t readHeader() {
    const std::string order = readBytes(2);
    if (order != "II" && order != "MM") return 0;
    isBigEndian = order == "MM";
    const uint64_t version = readNumber(2);
    if (version != 42 && version != 43) return 0;
    offsetBytes = version == 43 ? 8 : 4;
    if (version == 43) readNumber(4); // size of offsets, and a zero
    const uint64_t first = readNumber(offsetBytes);
    return file ? first : 0;
  }

  /* Returns the next directory's offset. */
  uint64_t readDirectory(uint64_t offset, std::string& text) {
    file.seekg(std::streamoff(offset));
    const uint64_t entries = readNumber(offsetBytes == 8 ? 8 : 2);
    for (uint64_t i = 0; i < entries && file; i++) {
      const uint64_t tag = readNumber(2), type = readNumber(2), count = readNumber(offsetBytes);
      const std::streampos value = file.tellg();
      if (tag == nodataTag && type == asciiType && count <= longestText) {
        if (count > offsetBytes) file.seekg(std::streamoff(readNumber(offsetBytes)));
        text = readBytes(size_t(count)).c_str(); // ends at the first zero
        if (!file) return 0;
      }
      file.seekg(value + std::streamoff(offsetBytes));
    }
    return readNumber(offsetBytes);
  }

  std::ifstream file;
  bool isBigEndian = false;
  unsigned offsetBytes = 4;
};

} // namespace

std::vector<std::string> readGdalNodata(const std::string& path) { return TiffReader(path).run(); }

} // namespace programs
