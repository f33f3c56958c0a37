// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes the primitive numbers of a block's quads (format/prim_ids.h), as the first pattern that fits, or a
 * table. */

#include "../format/block.h"
#include <algorithm>
#include <vector>

namespace cvert { inline namespace CVERT_ISA {
/*! Primitive numbers of a patch's quads. */
struct QuadNumbers {
  uint32_t numbering;            //!< without pattern, and without first corners if `firstCorners` is not empty
  unsigned width;                //!< quads per row
  std::vector<uint32_t> numbers; //!< row by row

  /* For quads of two triangles, row by row. Both are empty if second triangles follow first ones and `numbering`
   * contains the first corners. Blocks in which the distance from first to second triangles or the first corners
   * differ have triangle tables: there, numbers must differ by less than 2^30. */
  std::vector<uint32_t> seconds;     //!< numbers of second triangles
  std::vector<uint8_t> firstCorners; //!< bits 4..7 of numberings
};

/*! Call choosePattern() before the block is encoded, and finish() afterwards. */
class NumbersEncoder {
public:
  /*! Upper bound of the bytes that finish() adds and clears after the block. */
  static const size_t maxBytes = 8 * vertBlockQuads * vertBlockQuads + sizeof(VertTrianglePairs) + 16;

  uint32_t numbering; //!< for VertHeader::patchQuads
  /*! VertPrimIDs to store after the header. finish() replaces them there by offsets if it appends a section. */
  VertPrimIDs pattern;

  /*! Chooses the pattern for the block of width x height quads at quad x0, y0 of the patch. */
  void choosePattern(const QuadNumbers& patch, unsigned x0, unsigned y0, unsigned width, unsigned height) {
    this->width = width;
    this->height = height;
    distance = 1;
    lowest = ~0u;
    highest = 0;
    copy(patch.numbers, patch.width, x0, y0, numbers);
    extendRange(numbers);
    uint32_t blockNumbering = patch.numbering;
    if (!patch.seconds.empty()) {
      uint32_t seconds[vertBlockQuads * vertBlockQuads];
      uint8_t firstCorners[vertBlockQuads * vertBlockQuads];
      copy(patch.seconds, patch.width, x0, y0, seconds);
      copy(patch.firstCorners, patch.width, x0, y0, firstCorners);
      distance = seconds[0] - numbers[0];
      bool isUniform = true;
      for (unsigned i = 0; i < width * height; i++)
        isUniform = isUniform && seconds[i] - numbers[i] == distance && firstCorners[i] == firstCorners[0];
      if (!isUniform) {
        extendRange(seconds);
        for (unsigned i = 0; i < width * height; i++) {
          entries[2 * i] = (numbers[i] - lowest) << firstCornerBits | firstCornerOfTriangle(firstCorners[i], false);
          entries[2 * i + 1] = (seconds[i] - lowest) << firstCornerBits | firstCornerOfTriangle(firstCorners[i], true);
        }
        return setTable(patch.numbering, primIDsInTriangleTable);
      }
      blockNumbering |= firstCorners[0] | (distance == 1 ? 0 : primIDsOfTrianglePairs);
    }
    if (tryRows(blockNumbering) || tryRecursive(blockNumbering)) return;
    for (unsigned i = 0; i < width * height; i++) entries[i] = numbers[i] - lowest;
    setTable(blockNumbering, primIDsInTable);
  }

  /*! Sets the base of the numbers, and appends VertTrianglePairs and the table if necessary. bytes: size of the
   *  block. Returns its new size. */
  size_t finish(VertHeader* header, size_t bytes) const {
    header->primID = base;
    if (haveTrianglePairs(numbering)) bytes = writeTrianglePairs((uint8_t*)header, bytes);
    return haveTable(numbering) ? writeTable((uint8_t*)header, bytes) : bytes;
  }

private:
  size_t writeTrianglePairs(uint8_t* block, size_t bytes) const {
    const size_t begin = (bytes + 3) & ~size_t(3);
    memset(block + bytes, 0, begin - bytes);
    const VertPrimIDs stored = {uint32_t(begin), 0};
    memcpy(block + vertHeaderBytes, &stored, sizeof(stored));
    const VertTrianglePairs pairs = {pattern, distance};
    memcpy(block + begin, &pairs, sizeof(pairs));
    return begin + sizeof(pairs);
  }

  size_t writeTable(uint8_t* block, size_t bytes) const {
    const VertPrimIDs table = {uint32_t(bytes), pattern.y};
    memcpy(block + (haveTrianglePairs(numbering) ? bytes - sizeof(VertTrianglePairs) : vertHeaderBytes), &table,
           sizeof(table));
    uint8_t* const out = block + bytes;
    const unsigned count = width * height * entriesPerQuad(numbering);
    const size_t size = (bytesOfNumberTable(count, table.y) + 3) & ~size_t(3);
    memset(out, 0, size + sizeof(uint64_t));
    for (unsigned i = 0; i < count; i++) {
      const uint32_t bit = table.y * i;
      uint64_t bits;
      memcpy(&bits, out + bit / 8, sizeof(bits));
      bits |= uint64_t(entries[i]) << (bit % 8);
      memcpy(out + bit / 8, &bits, sizeof(bits));
    }
    return bytes + size;
  }

  template<typename Value>
  void copy(const std::vector<Value>& values, unsigned stride, unsigned x0, unsigned y0, Value* out) const {
    for (unsigned y = 0; y < height; y++)
      std::copy_n(values.begin() + (size_t(y0 + y) * stride + x0), width, out + y * width);
  }

  /*! Extends lowest and highest by the values of all quads. */
  void extendRange(const uint32_t* values) {
    lowest = std::min(lowest, *std::min_element(values, values + width * height));
    highest = std::max(highest, *std::max_element(values, values + width * height));
  }

  bool tryRows(uint32_t blockNumbering) {
    numbering = blockNumbering | primIDsInRows;
    base = numbers[0];
    pattern.x = width > 1 ? numbers[1] - base : 0;
    pattern.y = height > 1 ? numbers[width] - base : 0;
    return matches();
  }

  bool tryRecursive(uint32_t blockNumbering) {
    const uint32_t step = isTriangleNumbering(blockNumbering) && !haveTrianglePairs(blockNumbering) ? 2 : 1;
    auto code = [&](unsigned i) { return (numbers[i] - lowest) / step; };
    if ((highest - lowest) / step > 255) return false;
    base = lowest;
    numbering = blockNumbering | primIDsRecursive | code(0) << 8;
    pattern.x = pattern.y = 0;
    for (unsigned i = 0; i < maxVertLevel; i++) {
      if ((1u << i) < width) pattern.x |= (code(1u << i) ^ code(0)) << (8 * i);
      if ((1u << i) < height) pattern.y |= (code((1u << i) * width) ^ code(0)) << (8 * i);
    }
    return matches();
  }

  void setTable(uint32_t blockNumbering, uint32_t kind) {
    numbering = blockNumbering | kind;
    base = lowest;
    pattern.x = 0; // writeTable stores the table's offset instead
    pattern.y = 0; // bits per entry
    const uint32_t most = *std::max_element(entries, entries + width * height * entriesPerQuad(numbering));
    while ((uint64_t(most) >> pattern.y) != 0) pattern.y++;
  }

  bool matches() const {
    for (unsigned y = 0; y < height; y++)
      for (unsigned x = 0; x < width; x++)
        if (base + patternNumber(numbering, pattern, x, y) != numbers[y * width + x]) return false;
    return true;
  }

  unsigned width, height; //!< in quads
  uint32_t numbers[vertBlockQuads * vertBlockQuads];
  uint32_t entries[2 * vertBlockQuads * vertBlockQuads]; //!< entries of the table
  uint32_t distance;                                     //!< from first to second triangles
  uint32_t lowest, highest, base;
};
}} // namespace cvert::CVERT_ISA
