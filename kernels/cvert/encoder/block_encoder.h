// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lossless encoder of a static cVERT block (format/block.h), except that vertices that are not finite become NaN, and
 * that -0, and denormal floats if the processor flushes them, may become 0. Base of motion_encoder.h. Blocks are
 * smaller if callers snap vertices to a lattice first (lattice.h). */

#include "box_encoder.h"

namespace cvert { inline namespace CVERT_ISA {
struct VertStatistics {
  uint32_t invalidQuads = 0; //!< quads with a vertex that is not finite
  uint32_t fieldBytes = 0;   //!< bytes of fields and remainders, of a moving block: at its first step
  bool raw = false;          //!< the block, or a step of a moving block, is raw
};

/*! Size of the block, position in its patch, and edges or primitive numbers. */
struct VertPlacement {
  uint32_t region, patchQuads; //!< packRegion(), packPatchQuads()
  bool hasEdges = false, hasPrimIDs = false;
  VertEdges edges = {0, 0};     //!< stored if hasEdges
  VertPrimIDs numbers = {0, 0}; //!< stored if hasPrimIDs

  VertPlacement(uint32_t region, uint32_t patchQuads) : region(region), patchQuads(patchQuads) {}
  VertPlacement(uint32_t region, uint32_t patchQuads, const VertEdges& edges)
    : region(region),
      patchQuads(patchQuads),
      hasEdges(true),
      edges(edges) {}

  /*! Stores the numbering of quads instead of the patch's size. */
  VertPlacement(uint32_t region, uint32_t numbering, const VertPrimIDs& numbers)
    : region(region),
      patchQuads(numbering),
      hasPrimIDs(true),
      numbers(numbers) {}

  uint32_t info() const { return uint32_t(hasEdges) << 29 | uint32_t(hasPrimIDs) << 30; }

  /*! Sets region, patchQuads and info, and the part after the header. info: with the bits of info(). */
  void write(VertHeader& header, uint32_t info) const {
    header.region = region;
    header.patchQuads = patchQuads;
    header.info = info;
    if (hasEdges) memcpy(&header + 1, &edges, sizeof(edges));
    if (hasPrimIDs) memcpy(&header + 1, &numbers, sizeof(numbers));
  }
};

/*! Set `vertices`, then call encode(), for any number of blocks, by one thread at a time. */
class VertEncoder : public BlockVertices {
public:
  /*! Upper bound of the bytes that encode() writes. NumbersEncoder may append more. */
  static const size_t maxBytes = vertHeaderBytes + vertEdgesBytes + vertMotionBytes + vertRemaindersBytes +
                                 sizeof(float) * (6 * maxSide * maxSide + boxPlanes * maxVertGroups) + 64;

  /*! block: maxBytes, aligned to 4. Adds to the sums of `statistics`, and sets `raw` if there is a block. Returns the
   *  size in bytes, a multiple of 4, or 0 if no vertex is finite. The caller sets VertHeader::surface and primID. */
  size_t encode(const VertPlacement& placement, uint8_t* block, VertStatistics& statistics) {
    setSize(placement.region);
    computeBounds();
    if (!allFinite) statistics.invalidQuads += countInvalidQuads();
    if (!anyFinite()) return 0;
    const bool packed =
        allFinite && chooseSpacings() && pack(placement, placement.info(), block, [](int, const CellEncoder&) {});
    if (packed) {
      VertHeader& header = *(VertHeader*)block;
      boxes.begin(*this);
      boxes.addGroups();
      header.info |= boxes.write(block + layout.margins);
      uint32_t shift;
      header.bounds = boxes.encodeBounds(0, shift);
      header.info |= shift << 25;
      statistics.fieldBytes += uint32_t(end - (block + layout.cell));
    } else packRaw(placement, placement.info(), block);
    statistics.raw = !packed;
    padTo4(block);
    return size_t(end - block);
  }

protected:
  /*! Writes everything but boxes. Requires chooseSpacings(). Returns false if the block must be raw: it would
   *  not be smaller, or a spacing is too large. Calls onCell(g,cell) before encoding a cell, with g = -1 for the
   *  first cell, and again for all cells if it starts over with coarser spacings. */
  template<typename OnCell>
  bool pack(const VertPlacement& placement, uint32_t info, uint8_t* block, const OnCell& onCell) {
    for (bool isBalanced = false;;) {
      computeCoordinates();
      VertHeader& header = begin(placement, info | uint32_t(hasRemainders()) << 24, block);
      if (!packCells(header, block, onCell)) {
        if (!coarsen(cell.excess)) return false;
        continue;
      }
      if (isBalanced || !hasRemainders()) break;
      int bits[3];
      if (!findMovableBits(bits)) break;
      isBalanced = true;
      if (!coarsen(bits)) return false;
    }
    appendRemainders(*this, block, layout.remainders);
    return size_t(end - block) < layout.rawBytes;
  }

  /*! Appends the remainders, and writes their word at start+wordOffset. start: of the block or step. */
  void appendRemainders(const BlockVertices& vertices, uint8_t* start, uint32_t wordOffset) {
    if (!vertices.hasRemainders()) return;
    uint32_t word;
    end = vertices.writeRemainders(end, uint32_t(end - start), word);
    memcpy(start + wordOffset, &word, sizeof(word));
  }

  /*! Appends zeros up to a multiple of 4 bytes. */
  void padTo4(const uint8_t* start) {
    while ((end - start) % 4 != 0) *end++ = 0;
  }

  void packRaw(const VertPlacement& placement, uint32_t info, uint8_t* block) {
    VertHeader& header = begin(placement, info | rawInfo, block);
    copyTo((float(*)[3])(block + layout.vertices));
    float* boxes = (float*)(block + layout.boxes);
    for (int k = 0; k < 3; k++) {
      header.origin[k] = anyFinite() ? lower[k] : 0.0f;
      for (uint32_t g = 0; g < layout.groups; g++) {
        float lo = INFINITY, hi = -INFINITY; // kept if the group has no finite vertex
        extendByGroup(g, k, lo, hi);
        boxes[k * layout.groups + g] = lo;
        boxes[(3 + k) * layout.groups + g] = hi;
      }
    }
    end = block + layout.rawBytes;
  }

  VertLayout layout;
  uint8_t* end; //!< end of the written bytes
  CellEncoder cell;
  BoxEncoder boxes;
  uint32_t residualBits[3]; //!< per axis, summed over groups

private:
  /*! In blocks with remainders, bits of residuals beyond this many become remainders: a vertex between groups has a
   *  residual in each of their cells, but only one remainder. */
  static const int noiseBits = 5;

  /*! bits: receives the bits per axis that can move from residuals to remainders. Returns false if there are none. */
  bool findMovableBits(int bits[3]) const {
    bool any = false;
    for (int k = 0; k < 3; k++) {
      const int mean = int(residualBits[k] / layout.groups);
      bits[k] = remainderBits[k] == remaindersAreFloats ? 0 : std::max(mean - noiseBits, 0);
      any |= bits[k] > 0;
    }
    return any;
  }

  /*! Clears the sections before the first cell's fields, and writes the parts of the header that do not depend on
   *  vertices. */
  VertHeader& begin(const VertPlacement& placement, uint32_t info, uint8_t* block) {
    layout = vertLayout(placement.region, info);
    memset(block, 0, layout.cell);
    VertHeader& header = *(VertHeader*)block;
    placement.write(header, info);
    writeVersion(header.corners);
    return header;
  }

  void gatherCell(uint32_t x0, uint32_t y0, uint32_t step) {
    for (int k = 0; k < 3; k++) gather(coordinates[k], x0, y0, step, cell.vertices[k]);
  }

  /*! Returns false if residuals need too many bits. */
  template<typename OnCell>
  bool packCells(VertHeader& header, uint8_t* block, const OnCell& onCell) {
    gatherCell(0, 0, groupQuads);
    cell.predict(quads, groupQuads);
    onCell(-1, cell);
    if (!cell.encode()) return false;
    header.word = cell.word;
    write(header.origin, header.corners, header.word);
    end = cell.write(block + layout.cell);
    for (uint32_t& sum : residualBits) sum = 0;
    for (uint32_t g = 0; g < layout.groups; g++) {
      const uint32_t gx = g % layout.groupsX, gy = g / layout.groupsX;
      gatherCell(groupQuads * gx, groupQuads * gy, 1);
      const uint32_t sides[2] = {quadsOfGroup(quads[0], gx), quadsOfGroup(quads[1], gy)};
      cell.predict(sides, 1);
      onCell(int(g), cell);
      if (!cell.encode()) return false;
      for (int i = 0; i < 3; i++) residualBits[cellAxis(cell.word, i)] += uint32_t(cellBits(cell.word, i));
      const uint16_t low = uint16_t(cell.word);
      memcpy(block + layout.words + 2 * g, &low, sizeof(low));
      block[layout.wordsHigh + g] = uint8_t(cell.word >> 16);
      end = cell.write(end);
    }
    return true;
  }

  void extendByGroup(uint32_t g, int axis, float& lo, float& hi) const {
    const uint32_t x0 = groupQuads * (g % layout.groupsX), y0 = groupQuads * (g / layout.groupsX);
    for (uint32_t y = y0; y <= std::min(y0 + groupQuads, quads[1]); y++)
      for (uint32_t x = x0; x <= std::min(x0 + groupQuads, quads[0]); x++)
        if (isFinite(vertexAt(x, y))) {
          lo = std::min(lo, vertexAt(x, y)[axis]);
          hi = std::max(hi, vertexAt(x, y)[axis]);
        }
  }
};
}} // namespace cvert::CVERT_ISA
