// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Validates bytes that may be a cVERT block: all that decoders do not check. Vertices, boxes, bounds and primitive
 * numbers may have any value. */

#include "../portable/reason.h"
#include "../format/motion.h"
#include "../format/tile.h"

namespace cvert { inline namespace CVERT_ISA {
/*! True if a patch may begin at these face parameters, in halves. Faces with four corners begin at 0. Embree places
 *  sub-patches of other faces from 1/2 on, 2 apart, up to 4 in a row. */
inline bool isPatchCorner(uint32_t u, uint32_t v) {
  return (u == 0 && v == 0) || (u % 4 == 1 && v % 4 == 1 && u <= 13 && v <= 13);
}

class VertValidation {
public:
  /*! See validateVert. Reads at most `bytes` bytes. */
  static Reason validate(const void* data, size_t bytes) {
    if (bytes < vertHeaderBytes) return Reason::damaged("it has % bytes: its header needs %", bytes, vertHeaderBytes);
    const VertHeader& header = *(const VertHeader*)data;
    if (const Reason reason = validateVersion(header)) return reason;
    for (float x : header.origin)
      if (!std::isfinite(x)) return Reason::damaged("its origin is not finite");
    const VertLayout layout = vertLayout(header.region, header.info);
    if (bytes < layout.margins)
      return Reason::damaged("it has % bytes: header, edges or numbers, and motion need %", bytes, layout.margins);
    if (const Reason reason = hasPrimIDs(header.info) ? validateNumbers(header) : validatePatch(header)) return reason;
    size_t end;
    if (const Reason reason = validateFirstStep(header, layout, bytes, end)) return reason;
    if (isMoving(header.info))
      if (const Reason reason = validateMotion(header, layout, bytes, end)) return reason;
    return validateTable(header, end, bytes);
  }

private:
  static Reason validateVersion(const VertHeader& header) {
    const uint32_t version = versionOfCorners(header.corners[4], header.corners[5]);
    if (version < oldestVertVersion)
      return Reason::unsupported("it has version % of the format: this library reads % and later", version,
                                 oldestVertVersion);
    if (version > vertFormatVersion)
      return Reason::unsupported("it has version % of the format: this library reads versions up to %", version,
                                 vertFormatVersion);
    if (reservedOfCorners(header.corners[4], header.corners[5]) != 0)
      return Reason::unsupported("reserved bits of its corners are set: expected 0");
    if (hasEdges(header.info) && hasPrimIDs(header.info))
      return Reason::unsupported("it has both edges and numbers: expected at most one of them");
    return Reason();
  }

  /*! Checks axis and slopes. word: of a cell, or `info` of a header or step. */
  static bool hasValidSlopes(uint32_t word) {
    return cellMainAxis(word) < 3 && cellSlope(word, 1) >= -maxSlope && cellSlope(word, 2) >= -maxSlope;
  }

  static Reason validateFirstCell(uint32_t word, const uint32_t corners[6]) {
    const VertSpacing spacing = vertSpacing(word, corners);
    for (float x : spacing.at)
      if (!(x >= std::numeric_limits<float>::min() && x < infinity))
        return Reason::damaged("a spacing is not a normal float");
    return hasValidSlopes(word) ? Reason()
                                : Reason::damaged("the main axis or a slope of its first cell is out of range");
  }

  /*! end: receives the end of the step, in bytes from the start of the block. */
  static Reason validateFirstStep(const VertHeader& header, const VertLayout& layout, size_t bytes, size_t& end) {
    end = layout.rawBytes;
    if (isTile(header.info)) return Reason::unsupported("it is a tile: expected a block");
    if (isRaw(header.info))
      return bytes < end ? Reason::damaged("it has % bytes: its vertices and boxes need %", bytes, end) : Reason();
    if (const Reason reason = validateFirstCell(header.word, header.corners)) return reason;
    if (!hasValidSlopes(header.info))
      return Reason::damaged("its sheared axis or a slope of its boxes is out of range");
    if (bytes < layout.cell)
      return Reason::damaged("it has % bytes: header, margins and words need %", bytes, layout.cell);
    const uint8_t* block = (const uint8_t*)&header;
    end = layout.cell + cellBytes(header.word);
    for (uint32_t g = 0; g < layout.groups; g++) {
      const uint32_t word = wordOfGroup(block, layout.words, layout.wordsHigh, true, g);
      if (!hasValidSlopes(word)) return Reason::damaged("the main axis or a slope of group % is out of range", g);
      end += cellBytes(word);
    }
    if (bytes < end) return Reason::damaged("it has % bytes: its fields need %", bytes, end);
    if (!hasRemainders(header.info)) return Reason();
    return validateRemainders(vertSpacing(header.word, header.corners), wordAt(block, layout.remainders / 4),
                              header.region, bytes, end);
  }

  /*! end: end of the fields; receives the end of the remainders, both from the start of the block or later step. */
  static Reason validateRemainders(const VertSpacing& spacing, uint32_t remainders, uint32_t region, size_t bytes,
                                   size_t& end) {
    if (remainders & 0x8000u) return Reason::unsupported("a reserved bit of its remainders is set: expected 0");
    for (int k = 0; k < 3; k++) {
      const uint32_t bits = remainderBits(remainders, k);
      if (bits == remaindersAreFloats) continue;
      if (bits > maxRemainderBits)
        return Reason::damaged("its remainders have % bits: expected at most %, or 31 for floats", bits,
                               maxRemainderBits);
      if (!(remainderSpacing(spacing.at[k], bits) >= std::numeric_limits<float>::min()))
        return Reason::damaged("the spacing of its remainders is not a normal float");
    }
    if (remainderOffset(remainders) < end)
      return Reason::damaged("its remainders begin at %: expected % or later", remainderOffset(remainders), end);
    end = size_t(remainderOffset(remainders)) + bytesOfRemainders(remainders, region);
    return bytes < end ? Reason::damaged("its remainders end at %: expected at most %", end, bytes) : Reason();
  }

  /*! end: end of the first step; receives the end of the last */
  static Reason validateMotion(const VertHeader& header, const VertLayout& layout, size_t bytes, size_t& end) {
    const VertMotion motion = motionOf(&header);
    if (!std::isfinite(motion.begin) || !(motion.begin < motion.end) || !std::isfinite(motion.end))
      return Reason::damaged("its time range is empty or not finite");
    if (motion.numSteps < 2 || motion.numSteps > maxTimeSteps)
      return Reason::damaged("it has % time steps: expected 2 to %", motion.numSteps, maxTimeSteps);
    if (motion.steps < end || motion.steps % 4 != 0)
      return Reason::damaged("the offsets of its time steps begin at %: expected a multiple of 4 from % on",
                             motion.steps, end);
    end = size_t(motion.steps) + 4 * (motion.numSteps - 1);
    if (bytes < end) return Reason::damaged("it has % bytes: the offsets of its time steps need %", bytes, end);
    for (uint32_t s = 1; s < motion.numSteps; s++) {
      const VertStep* const step = stepOf(&header, s);
      const size_t begin = size_t((const uint8_t*)step - (const uint8_t*)&header);
      if (begin < end || begin % 4 != 0)
        return Reason::damaged("a time step begins at %: expected a multiple of 4 from % on", begin, end);
      if (bytes < begin + vertStepBytes)
        return Reason::damaged("it has % bytes: the header of a time step needs %", bytes, begin + vertStepBytes);
      if (const Reason reason = validateStep(header, layout, *step, bytes - begin, end)) return reason;
      end += begin;
    }
    return Reason();
  }

  /*! end: receives the size of the step */
  static Reason validateStep(const VertHeader& header, const VertLayout& layout, const VertStep& step, size_t bytes,
                             size_t& end) {
    for (float x : step.origin)
      if (!std::isfinite(x)) return Reason::damaged("the origin of a time step is not finite");
    if (versionOfCorners(step.corners[4], step.corners[5]) != 0 ||
        reservedOfCorners(step.corners[4], step.corners[5]) != 0)
      return Reason::unsupported("reserved bits of a time step's corners are set: expected 0");
    if (step.rotation & 1u << 23)
      return Reason::unsupported("the reserved bit of a time step's rotation is set: expected 0");
    const VertStepLayout at = vertStepLayout(header.region, step.info);
    end = at.rawBytes;
    if (isRaw(step.info))
      return bytes < end ? Reason::damaged("a time step has % bytes: its vertices need %", bytes, end) : Reason();
    if (const Reason reason = validateFirstCell(step.word, step.corners)) return reason;
    if (!hasValidSlopes(step.info))
      return Reason::damaged("the sheared axis or a slope of a time step's boxes is out of range");
    if (isRaw(header.info) && ((step.rotation & 65535u) || isFirstCellRotated(step.info)))
      return Reason::damaged("a time step predicts residuals from the first step, which is raw");
    if (((step.rotation >> 16) & 7u) == 7u)
      return Reason::damaged("the scale of a time step's matrix is 7: expected 0 to 6");
    if (bytes < at.cell)
      return Reason::damaged("a time step has % bytes: its margins and words need %", bytes, at.cell);
    end = at.cell + cellBytes(step.word);
    for (uint32_t g = 0; g < layout.groups; g++) {
      const uint32_t word = wordOfGroup(&step, at.words, at.wordsHigh, laterStepStoresUpperBits(step.info), g);
      if (!hasValidSlopes(word))
        return Reason::damaged("the main axis or a slope of group % of a time step is out of range", g);
      end += cellBytes(word);
    }
    if (bytes < end) return Reason::damaged("a time step has % bytes: its fields need %", bytes, end);
    if (!hasRemainders(step.info)) return Reason();
    return validateRemainders(vertSpacing(step.word, step.corners), wordAt(&step, at.remainders / 4), header.region,
                              bytes, end);
  }

  static Reason validateNumbers(const VertHeader& header) {
    const uint32_t numbering = header.patchQuads;
    const bool isTableOfTriangles = patternOfPrimIDs(numbering) == primIDsInTriangleTable;
    if (numbering >> 17 || (haveTrianglePairs(numbering) && (isTableOfTriangles || !isTriangleNumbering(numbering) ||
                                                             isSingleTriangleNumbering(numbering))))
      return Reason::unsupported("its numbering, %, is unknown", numbering);
    if (isTableOfTriangles && (!isTriangleNumbering(numbering) || isSingleTriangleNumbering(numbering) ||
                               (numbering & packFirstCorners(3, 3))))
      return Reason::unsupported("the numbering with a table of triangles, %, is unknown", numbering);
    for (bool isSecond : {false, true})
      if (firstCornerOfTriangle(header.patchQuads, isSecond) > 2)
        return Reason::damaged("a triangle starts with corner 3: expected 0 to 2");
    return Reason();
  }

  /*! end: end of all sections before the table. */
  static Reason validateTable(const VertHeader& header, size_t end, size_t bytes) {
    const uint32_t numbering = header.patchQuads;
    if (!hasPrimIDs(header.info)) return Reason();
    if (haveTrianglePairs(numbering)) {
      const VertPrimIDs stored = storedNumbersOf(&header);
      if (stored.x < end || stored.x % 4 != 0 || stored.y != 0)
        return Reason::damaged("the numbers of its second triangles begin at %: expected a multiple of 4 from % on, "
                               "followed by 0",
                               stored.x, end);
      end = size_t(stored.x) + sizeof(VertTrianglePairs);
      if (bytes < end) return Reason::damaged("it has % bytes: the numbers of its second triangles need %", bytes, end);
    }
    if (!haveTable(numbering)) return Reason();
    const VertPrimIDs numbers = numbersOf(&header);
    if (numbers.x < end)
      return Reason::damaged("its table of numbers begins at %: expected % or later", numbers.x, end);
    if (numbers.y > 32u)
      return Reason::damaged("its table of numbers has % bits per number: expected at most 32", numbers.y);
    const uint32_t entries = vertQuadsX(header.region) * vertQuadsY(header.region) * entriesPerQuad(numbering);
    const size_t needed = size_t(numbers.x) + bytesOfNumberTable(entries, numbers.y);
    if (bytes < needed) return Reason::damaged("it has % bytes: its table of numbers needs %", bytes, needed);
    return patternOfPrimIDs(numbering) == primIDsInTriangleTable ? validateFirstCorners(header) : Reason();
  }

  /*! Requires a table of triangles within the block. */
  static Reason validateFirstCorners(const VertHeader& header) {
    for (uint32_t y = 0; y < vertQuadsY(header.region); y++)
      for (uint32_t x = 0; x < vertQuadsX(header.region); x++)
        for (bool isSecond : {false, true})
          if (firstCornerOfTriangle(primitiveOfQuad(&header, x, y, isSecond).numbering, isSecond) > 2)
            return Reason::damaged("a triangle starts with corner 3: expected 0 to 2");
    return Reason();
  }

  static Reason validatePatch(const VertHeader& header) {
    const uint32_t quads[2] = {patchQuadsX(header.patchQuads), patchQuadsY(header.patchQuads)};
    if (vertFirstX(header.region) + vertQuadsX(header.region) > quads[0] ||
        vertFirstY(header.region) + vertQuadsY(header.region) > quads[1])
      return Reason::damaged("it lies outside of its patch of % x % quads", quads[0], quads[1]);
    if (!hasEdges(header.info)) return Reason();
    const VertEdges edges = edgesOf(&header);
    if (edges.high & 0xF000F000u) return Reason::unsupported("reserved bits of its edges are set: expected 0");
    const uint32_t u = vertCornerU(edges), v = vertCornerV(edges);
    if (!isPatchCorner(u, v))
      return Reason::damaged("its patch starts at (%/2,%/2): expected (0,0), or each 1/2, 5/2, 9/2 or 13/2", u, v);
    for (int s = 0; s < 4; s++)
      if (vertRate(edges, s) > quads[s & 1])
        return Reason::damaged("an edge has rate %: expected at most %, the quads of its patch", vertRate(edges, s),
                               quads[s & 1]);
    return Reason();
  }
};

/*! Returns the first error in the cVERT block at `data`, which must be aligned to 4 bytes. bytes: number of readable
 *  bytes; the block may be shorter. Decoders of valid blocks read up to vertReadPadding bytes after its end. */
inline Reason validateVert(const void* data, size_t bytes) { return VertValidation::validate(data, bytes); }
}} // namespace cvert::CVERT_ISA
