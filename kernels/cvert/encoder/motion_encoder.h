// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lossless encoder of a moving cVERT block, step by step, see format/motion.h. */

#include "block_encoder.h"
#include "../format/motion.h"
#include "rotation_fit.h"
#include <vector>

namespace cvert { inline namespace CVERT_ISA {
struct MotionStatistics : public VertStatistics {
  uint32_t stepBytes = 0;     //!< of all steps but the first
  uint32_t rotatedGroups = 0; //!< sum over all steps that are not raw
};

/*! Call begin(), then for each step set vertices() and call addStep(), then finish(). Holds two steps in memory; each
 *  step completes the margins of the step before it. */
class MotionEncoder : private VertEncoder {
public:
  /*! Upper bound of a block's size. */
  static size_t maxBytes(size_t numSteps) {
    return VertEncoder::maxBytes +
           (numSteps - 1) * (sizeof(uint32_t) + vertStepBytes + vertRemaindersBytes + 3 * maxVertGroups +
                             3 * maxVertGroups + sizeof(float) * 6 * maxSide * maxSide + 64);
  }

  /*! Vertices of the next step, row by row, which the caller sets. */
  float (*vertices())[3] { return current().vertices; }

  /*! begin, end: times of the first and last step. numSteps: 2 to maxTimeSteps. out: receives the block
   *  until finish(), at least maxBytes(numSteps), aligned to 4. */
  void begin(const VertPlacement& placement, float begin, float end, uint32_t numSteps, uint8_t* out) {
    this->placement = placement;
    motion = {begin, end, numSteps, 0};
    block = out;
    step = 0;
    isEmpty = true;
    statistics = MotionStatistics();
    invalid.assign(size_t(vertQuadsX(placement.region)) * vertQuadsY(placement.region), false);
  }

  void addStep() {
    BlockVertices& now = current();
    now.setSize(placement.region);
    now.computeBounds();
    isEmpty &= !now.anyFinite();
    if (!now.allFinite) markInvalid(now);
    if (step == 0) packFirst();
    else packStep(now);
    padTo4(block);
    step++;
  }

  /*! Vertices of the step that was added last. */
  const BlockVertices& last() const { return (step - 1) % 2 ? other : *this; }

  /*! Returns the size in bytes, a multiple of 4, or 0 if no vertex is finite at any step. The caller sets
   *  VertHeader::surface and primID. */
  size_t finish(MotionStatistics& out) {
    for (bool isInvalid : invalid) statistics.invalidQuads += isInvalid;
    statistics.stepBytes = uint32_t(end - block) - motion.steps;
    out = statistics;
    return isEmpty ? 0 : size_t(end - block);
  }

private:
  static const uint32_t firstCell = maxVertGroups; //!< index of the first cell in `first` and `own`

  /*! Residuals of a cell, by axis. */
  typedef int Residuals[3][paddedVertices];

  BlockVertices& current() { return step % 2 ? other : *this; }
  BlockVertices& before() { return step % 2 ? *this : other; }

  void markInvalid(const BlockVertices& now) {
    for (uint32_t y = 0; y < now.quads[1]; y++)
      for (uint32_t x = 0; x < now.quads[0]; x++)
        if (!(isFinite(now.vertexAt(x, y)) && isFinite(now.vertexAt(x + 1, y)) && isFinite(now.vertexAt(x, y + 1)) &&
              isFinite(now.vertexAt(x + 1, y + 1))))
          invalid[y * now.quads[0] + x] = true;
  }

  void packFirst() {
    const uint32_t info = placement.info() | 1u << 31;
    const bool packed =
        allFinite && chooseSpacings() && pack(placement, info, block, [&](int g, const CellEncoder& cell) {
          memcpy(first[g < 0 ? firstCell : uint32_t(g)], cell.residuals, sizeof(Residuals));
        });
    if (packed) statistics.fieldBytes = uint32_t(end - (block + layout.cell));
    else packRaw(placement, info, block);
    VertHeader& header = *(VertHeader*)block;
    statistics.raw = wasRaw = isFirstRaw = !packed;
    padTo4(block);
    motion.steps = uint32_t(end - block);
    memcpy(block + motionOffset(header.info), &motion, sizeof(motion));
    end += sizeof(uint32_t) * (motion.numSteps - 1);
    marginsOfSegment = block + layout.margins;
    infoOfSegment = &header.info;
    boundsOfSegment = &header.bounds;
    if (packed) rotation.setFirst(first, layout.groups);
  }

  void packStep(BlockVertices& now) {
    const uint32_t offset = uint32_t(end - block);
    memcpy(block + motion.steps + 4 * (step - 1), &offset, sizeof(offset));
    VertStep& header = *(VertStep*)end;
    bool packed = now.allFinite && now.chooseSpacings() && packCellsOfStep(now, header);
    if (packed) appendRemainders(now, (uint8_t*)&header, vertStepBytes);
    const size_t rawBytes = vertStepLayout(placement.region, rawInfo).rawBytes;
    packed = packed && size_t(end - (uint8_t*)&header) < rawBytes;
    if (!packed) {
      memset(&header, 0, vertStepBytes);
      for (int k = 0; k < 3; k++) header.origin[k] = now.anyFinite() ? now.lower[k] : 0.0f;
      header.info = rawInfo;
      now.copyTo((float(*)[3])((uint8_t*)&header + vertStepBytes));
      end = (uint8_t*)&header + rawBytes;
    }
    statistics.raw |= !packed;
    for (uint32_t g = 0; packed && g < layout.groups; g++) statistics.rotatedGroups += header.rotation >> g & 1;
    // the segment that ends here: its margins are in the previous step
    if (packed && !wasRaw) {
      boxes.begin(before(), &now);
      boxes.addGroups();
      const uint32_t shiftAt = step == 1 ? 25 : 28;
      uint32_t shift;
      *boundsOfSegment = boxes.encodeBounds(0, shift);
      *infoOfSegment =
          (*infoOfSegment & ~(0xFFFFFFu | 15u << shiftAt)) | boxes.write(marginsOfSegment) | shift << shiftAt;
      header.endBounds = boxes.encodeBounds(1, shift);
      header.rotation |= shift << 19;
    }
    wasRaw = !packed;
    marginsOfSegment = (uint8_t*)&header + vertStepLayout(placement.region, header.info).margins;
    infoOfSegment = &header.info;
    boundsOfSegment = &header.bounds;
  }

  /*! Requires now.chooseSpacings(). Coarsens spacings until residuals fit. Returns false if one is then too large. */
  bool packCellsOfStep(BlockVertices& now, VertStep& header) {
    for (;;) {
      now.computeCoordinates();
      memset(&header, 0, vertStepBytes);
      if (tryCellsOfStep(now, header)) return true;
      if (!now.coarsen(cell.excess)) return false;
    }
  }

  bool tryCellsOfStep(const BlockVertices& now, VertStep& header) {
    const uint32_t groups = layout.groups;
    for (uint32_t g = 0; g <= groups; g++) predict(now, g < groups ? g : firstCell);
    if (!isFirstRaw) {
      rotation.fit(own);
      rotation.write(header);
    }
    // all words first: the offset of fields depends on them
    uint32_t words[maxVertGroups + 1];
    bool areRotated[maxVertGroups + 1], haveSlopes = false;
    for (uint32_t i = 0; i <= groups; i++) {
      const uint32_t g = i < groups ? i : firstCell;
      if (!encodeCell(g, words[g], areRotated[g])) return false;
      if (i < groups) {
        haveSlopes |= (words[g] >> 14) != 0;
        header.rotation |= uint32_t(areRotated[g]) << g;
      }
    }
    header.info = uint32_t(now.hasRemainders()) << 24 | uint32_t(areRotated[firstCell]) << 25 |
                  uint32_t(haveSlopes) << 26 | uint32_t(step + 1 < motion.numSteps) << 27;
    header.word = words[firstCell];
    now.write(header.origin, header.corners, header.word);
    const VertStepLayout to = vertStepLayout(placement.region, header.info);
    uint8_t* const data = (uint8_t*)&header;
    memset(data + to.margins, 0, to.words - to.margins);
    for (uint32_t g = 0; g < groups; g++) {
      const uint16_t low = uint16_t(words[g]);
      memcpy(data + to.words + 2 * g, &low, sizeof(low));
      if (haveSlopes) data[to.wordsHigh + g] = uint8_t(words[g] >> 16);
    }
    end = write(firstCell, words[firstCell], data + to.cell);
    for (uint32_t g = 0; g < groups; g++) end = write(g, words[g], end);
    return true;
  }

  /*! Sets own[g] to the residuals of a cell. */
  void predict(const BlockVertices& now, uint32_t g) {
    const bool isGroup = g != firstCell;
    const uint32_t gx = isGroup ? g % layout.groupsX : 0, gy = isGroup ? g / layout.groupsX : 0,
                   distance = isGroup ? 1 : groupQuads;
    for (int k = 0; k < 3; k++)
      now.gather(now.coordinates[k], groupQuads * gx, groupQuads * gy, distance, cell.vertices[k]);
    const uint32_t sides[2] = {isGroup ? quadsOfGroup(now.quads[0], gx) : now.quads[0],
                               isGroup ? quadsOfGroup(now.quads[1], gy) : now.quads[1]};
    cell.predict(sides, distance);
    memcpy(own[g], cell.residuals, sizeof(Residuals));
  }

  /*! Chooses between the residuals of a cell, own[g], and their difference from rotated residuals. Sets own[g] to the
   *  values that write() stores. Returns false if both have too many bits. */
  bool encodeCell(uint32_t g, uint32_t& word, bool& isRotated) {
    isRotated = false;
    int bits = maxFieldBits * 2;
    Residuals rest;
    if (!isFirstRaw) {
      rotation.subtract(first[g], own[g], rest);
      memcpy(cell.residuals, rest, sizeof(rest));
      isRotated = cell.encodeWithoutSlopes();
      if (isRotated) {
        word = cell.word;
        bits = cellFieldBits(word);
      }
    }
    if (bits > maxUntriedBits) {
      memcpy(cell.residuals, own[g], sizeof(Residuals));
      if (cell.encode() && cellFieldBits(cell.word) < bits) {
        word = cell.word;
        isRotated = false;
        memcpy(own[g], cell.residuals, sizeof(Residuals));
        return true;
      }
    }
    if (isRotated) memcpy(own[g], rest, sizeof(rest));
    return isRotated;
  }

  uint8_t* write(uint32_t g, uint32_t word, uint8_t* out) {
    cell.word = word;
    memcpy(cell.residuals, own[g], sizeof(Residuals));
    return cell.write(out);
  }

  //! encodeCell does not try the step's own residuals if rotated ones need at most this many bits per field
  static const int maxUntriedBits = 6;

  VertPlacement placement = VertPlacement(0, 0);
  VertMotion motion;
  uint8_t* block;
  uint32_t step;
  bool isEmpty, isFirstRaw, wasRaw;
  uint8_t* marginsOfSegment; //!< these three point into the previous step, where the current segment begins
  uint32_t *infoOfSegment, *boundsOfSegment;
  MotionStatistics statistics;
  std::vector<bool> invalid;                                  //!< quads that are invalid at any step
  BlockVertices other;                                        //!< vertices of odd steps
  Residuals first[maxVertGroups + 1], own[maxVertGroups + 1]; //!< by cell: residuals of the first and the current step
  RotationFit rotation;
};
}} // namespace cvert::CVERT_ISA
