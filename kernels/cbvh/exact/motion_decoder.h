// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* SIMD decoder of a segment of a moving cVERT block (cvert/format/motion.h), at both ends: first the data that groups
 * share, then the vertices of one group at a time. cvert/decoder/decoded_block.h is the scalar reference. */

#include "boxes.h"
#include "decoder.h"
#include "../base/codec_names.h"
#include "../../cvert/decoder/step_view.h"

namespace embree::isa::cbvh {
/*! Base of CellDecoder for residuals alone. */
struct ZeroBase {
  __forceinline vfloatV at(int, int) const { return vfloatV(zero); }
  __forceinline vfloatV last(int) const { return vfloatV(zero); }
};

/*! Base of CellDecoder: a CellBase plus the first step's residuals times a later step's matrix. */
class RotatedBase {
public:
  /*! first: residuals of the first step; must outlive this object. */
  __forceinline RotatedBase(const CellBase& base, const VertStep& step, const CellVertices& first)
    : base(base),
      first(first) {
    const float unit = 1.0f / float(1u << rotationShift(step.rotation));
    for (uint32_t i = 0; i < 9; i++) matrix[i] = float(rotationEntry(step, i)) * unit;
  }

  /*! Exact, fused or not: all numbers have at most 24 bits. */
  __forceinline vfloatV at(int axis, int vector) const {
    const int l = vectorWidth * vector;
    const float* row = matrix + 3 * axis;
    const vfloatV sum = madd(vfloatV(row[0]), vfloatV::load(first.at[0] + l),
                             madd(vfloatV(row[1]), vfloatV::load(first.at[1] + l),
                                  madd(vfloatV(row[2]), vfloatV::load(first.at[2] + l), vfloatV(0.5f))));
    return base.at(axis, vector) + floor(sum);
  }
  __forceinline vfloatV last(int axis) const { return base.last(axis); }

private:
  const CellBase base;
  const CellVertices& first;
  float matrix[9];
};

class MotionDecoder {
public:
  __forceinline explicit MotionDecoder(const VertHeader* block)
    : block(block),
      layout(vertLayout(block->region, block->info)),
      quadsX(vertQuadsX(block->region)),
      quadsY(vertQuadsY(block->region)) {}

  /*! Decodes the entry of a block in a segment, except for out.key, which must be set. Omits groups that no ray
   *  can hit in the segment. */
  void decode(uint32_t segment, VertSegmentEntry& out) const {
    out.lanes = ((1u << layout.groupsX) - 1) * 0x1111u & ((1u << 4 * layout.groupsY) - 1);
    const StepView steps[2] = {viewOfStep(block, layout, segment), viewOfStep(block, layout, segment + 1)};
    for (int e = 0; e < 2; e++)
      for (int k = 0; k < 3; k++) out.origins[e][k] = steps[e].origin[k];
    const bool isSheared = !cvert::isRaw(steps[0].info) && !cvert::isRaw(steps[1].info);
    const float extent = likely(isSheared) ? SegmentBounds(block, segment).extent() : 0.0f;
    for (int k = 0; k < 3; k++) out.extent[k] = extent;
    setShear(steps[0].info, isSheared, out);
    for (int e = 0; e < 2; e++) {
      const StepView& step = steps[e];
      if (unlikely(cvert::isRaw(step.info))) continue;
      CellVertices corners;
      decodeCorners(step, corners);
      VertDecoder::pack(corners, out.steps[e].corners);
      const uint8_t* const high = step.storesUpperBits ? step.data + step.wordsHigh : nullptr;
      decodeGroupWords(step.data + step.words, high, step.cell + cellBytes(step.word), layout, out.steps[e].words,
                       out.steps[e].fieldOffsets);
      if (unlikely(!isSheared)) continue;
      const VertSpacing spacing = spacingOf(step.word, cornersOf(step));
      const PlanesDecoder planes(steps[0].info, steps[0].data + steps[0].margins, layout, spacing, step.origin);
      planes.decode(corners, out.planes[e]);
    }
    if (likely(isSheared)) widenSheared(out);
    else boxesOfVertices(out);
  }

  /*! True if the block is raw at a time step. */
  bool isRaw(uint32_t step) const { return cbvh::isRaw(step == 0 ? block->info : stepOf(block, step)->info); }

  /*! Decodes the vertices of the group in a lane at both ends, in world space. entry: output of decode().
   *  Does not set out.key. */
  void vertices(const VertSegmentEntry& entry, uint32_t lane, SegmentVertices& out) const {
    CellVertices first; // residuals of the first step, for a rotated group
    bool hasFirst = false;
    for (uint32_t e = 0; e < 2; e++) {
      const StepView step = viewOfStep(block, layout, entry.key.segment + e);
      const uint32_t gx = lane & 3, gy = lane >> 2;
      if (unlikely(cvert::isRaw(step.info))) {
        copyVertices(step.data + step.vertices, block->region, gx, gy, out.vertices[e]);
        continue;
      }
      const StepCells& cells = entry.steps[e];
      auto corner = [&](int c) { return coordinatesAt(cells.corners.at[vertTables.corners[lane][c]]); };
      const CellPrediction prediction(corner(0), corner(1), corner(2), corner(3));
      const CellBase base(prediction, true, quadsOfGroup(quadsX, gx), quadsOfGroup(quadsY, gy));
      const VertSpacing spacing = spacingOf(step.word, cornersOf(step));
      const CellWorldOutput world = {out.vertices[e], spacing, step.origin};
      const uint8_t* fields = step.data + cells.fieldOffsets[lane];
      const bool isRotated = isGroupRotated(step, gy * layout.groupsX + gx);
      if (isRotated && !hasFirst) {
        residualsOfFirst(entry, lane, first);
        hasFirst = true;
      }
      if (isRotated) decodeCell(cells.words[lane], fields, RotatedBase(base, laterStepOf(step), first), world);
      else decodeCell(cells.words[lane], fields, base, world);
      if (unlikely(step.remainders != 0))
        addRemainders(step.data, step.remainders, spacing, block->region, gx, gy, out.vertices[e]);
    }
  }

private:
  static __forceinline const uint32_t* cornersOf(const StepView& step) {
    return (const uint32_t*)(step.data + step.corners);
  }
  /*! Requires a step after the first. */
  static __forceinline const VertStep& laterStepOf(const StepView& step) { return *(const VertStep*)step.data; }

  /*! Decodes the first cell of a step, in lattice coordinates. */
  void decodeCorners(const StepView& step, CellVertices& out) const {
    auto corner = [&](int c) { return cornerAt(cornersOf(step), c); };
    const CellPrediction prediction(corner(0), corner(1), corner(2), corner(3));
    const CellBase base(prediction, false, quadsX, quadsY);
    if (isFirstCellRotated(step)) {
      CellVertices first;
      decodeCell(block->word, (const uint8_t*)block + layout.cell, ZeroBase(), CellLatticeOutput{first});
      decodeCell(step.word, step.data + step.cell, RotatedBase(base, laterStepOf(step), first), CellLatticeOutput{out});
    } else decodeCell(step.word, step.data + step.cell, base, CellLatticeOutput{out});
  }

  /*! Decodes a group's residuals at the first step. */
  void residualsOfFirst(const VertSegmentEntry& entry, uint32_t lane, CellVertices& out) const {
    if (entry.key.segment == 0) {
      decodeCell(entry.steps[0].words[lane], (const uint8_t*)block + entry.steps[0].fieldOffsets[lane], ZeroBase(),
                 CellLatticeOutput{out});
      return;
    }
    const StepView first = viewOfFirstStep(block, layout);
    const uint32_t g = (lane >> 2) * layout.groupsX + (lane & 3);
    decodeCell(wordOfGroup(first, g), first.data + fieldsOfGroup(first, g), ZeroBase(), CellLatticeOutput{out});
  }

  /*! Moves sheared planes outward, because interpolation rounds the origin, to which they are relative. */
  static void widenSheared(VertSegmentEntry& out) {
    float sheared = 0.0f;
    for (int k = 0; k < 3; k++)
      sheared += std::fabs(out.shear[k]) * motionSlack(out.origins[0][k], out.origins[1][k], out.extent[k]);
    const vfloatV slack(sheared);
    for (int e = 0; e < 2; e++)
      for (int l = 0; l < 16; l += vectorWidth) {
        float(*at)[16] = out.planes[e][out.shearedAxis].at;
        vfloatV::store(at[0] + l, vfloatV::load(at[0] + l) - slack);
        vfloatV::store(at[1] + l, vfloatV::load(at[1] + l) + slack);
      }
  }

  /*! Sets boxes of a segment with a raw end, which has no margins, from vertices. Requires all other members.
   *  Clears the lanes of groups that no ray can hit in the segment. */
  __noinline void boxesOfVertices(VertSegmentEntry& out) const {
    for (uint32_t rest = out.lanes; rest; rest &= rest - 1) {
      const uint32_t l = uint32_t(bsf(rest));
      SegmentVertices group;
      vertices(out, l, group);
      for (int end = 0; end < 2; end++) {
        float lower[3] = {pos_inf, pos_inf, pos_inf}, upper[3] = {neg_inf, neg_inf, neg_inf};
        for (int v = 0; v < cellVertices; v++) {
          const float(&at)[3][VertTables::lanes] = group.vertices[end].at;
          const float p[3] = {at[0][v], at[1][v], at[2][v]};
          if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))) continue;
          for (int k = 0; k < 3; k++) {
            lower[k] = min(lower[k], p[k]);
            upper[k] = max(upper[k], p[k]);
          }
        }
        if (!(lower[0] <= upper[0])) {
          out.lanes &= ~(1u << l);
          break;
        } // no quad is finite at both ends
        for (int k = 0; k < 3; k++) {
          out.planes[end][k].at[0][l] = lower[k];
          out.planes[end][k].at[1][l] = upper[k];
          out.extent[k] = max(out.extent[k], upper[k] - out.origins[end][k]);
        }
      }
    }
  }

  const VertHeader* block;
  const VertLayout layout;
  const uint32_t quadsX, quadsY;
};
} // namespace embree::isa::cbvh
