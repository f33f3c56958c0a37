// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* SIMD decoder of the boxes of a cVERT block's groups (cvert/format/block.h). Needs the corners of the groups and their
 * margins, but not the groups' other vertices. */

#include "../base/codec_names.h"
#include "../../cvert/rule/rule.h"
#include "quad_corners.h"
#include "cache.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

/*! vertSpacing with vector instructions. word: of the first cell. Reads 16 bytes at `corners`. */
__forceinline VertSpacing spacingOf(uint32_t word, const uint32_t corners[6]) {
  const __m128i values = _mm_loadu_si128((const __m128i*)corners);
  // saturation keeps signs: bits 15 of the first eight coordinates are the exponent on y, bits 14 the one on z
  const uint32_t bits = uint32_t(_mm_movemask_epi8(_mm_packs_epi16(values, _mm_slli_epi16(values, 1))));
  VertSpacing spacing;
  spacing.at[0] = floatOfBits((word >> 24) << 23);
  spacing.at[1] = floatOfBits((bits & 255u) << 23);
  spacing.at[2] = floatOfBits((bits >> 8) << 23);
  return spacing;
}

/*! Sets axis and shear. info: VertHeader::info or VertStep::info. isSheared: false if raw. */
__forceinline void setShear(uint32_t info, bool isSheared, VertAxes& axes) {
  axes.shearedAxis = likely(isSheared) ? shearedAxis(info) : 3;
  for (int k = 0; k < 3; k++) axes.shear[k] = 0.0f;
  if (likely(isSheared))
    for (int i = 0; i < 3; i++) axes.shear[axisAfter(axes.shearedAxis, i)] = worldShear(info, i);
}

/*! Sets `axes`. For a raw block, the caller must set the extent from the planes. */
__forceinline void setAxes(const VertHeader* block, VertAxes& axes) {
  const bool raw = isRaw(block->info);
  const float extent = unlikely(raw) ? 0.0f
                                     : vertExtent(block->info, block->bounds, boundsUnit(block->info),
                                                  spacingOf(block->word, block->corners));
  setShear(block->info, !raw, axes);
  for (int k = 0; k < 3; k++) {
    axes.origin[k] = block->origin[k];
    axes.extent[k] = extent;
  }
}

/*! Decodes the planes of all boxes: bounds of each group's four corners, moved outward by margins. */
class PlanesDecoder {
public:
  /*! info: as VertHeader::info. margins: for each axis one byte per group. The arguments must outlive this
   *  object. */
  __forceinline PlanesDecoder(uint32_t info, const uint8_t* margins, const VertLayout& layout,
                              const VertSpacing& spacing, const float* origin)
    : info(info),
      margins(margins),
      layout(layout),
      spacing(spacing),
      origin(origin) {}

  /*! corners: vertices of the first cell, in lattice coordinates. */
  __forceinline void decode(const CellVertices& corners, GroupPlanes planes[3]) const {
    const int m = shearedAxis(info);
    for (int k = 0; k < 3; k++)
      if (k != m) decode(k, corners.at[k], origin[k], planes[k]);

    const int m1 = axisAfter(m, 1), m2 = axisAfter(m, 2);
    const vfloatV s1(shearFactor(info, 1, spacing)), s2(shearFactor(info, 2, spacing));
    alignas(64) float sheared[VertTables::lanes];
    for (int c = 0; c < cellVectors; c++) {
      const int n = vectorWidth * c;
      vfloatV::store(sheared + n, madd(s2, vfloatV::load(corners.at[m2] + n),
                                       madd(s1, vfloatV::load(corners.at[m1] + n), vfloatV::load(corners.at[m] + n))));
    }
    decode(m, sheared, 0.0f, planes[m]);
  }

private:
  /*! Decodes the planes on axis k. vertices: coordinates on this axis. offset: world position of coordinate 0, or
   *  0 for the sheared axis. */
  __forceinline void decode(int k, const float* vertices, float offset, GroupPlanes& out) const {
    alignas(16) uint8_t expanded[24]; // vectors of four load 8 bytes, the last from byte 12 on
    const uint8_t* axisMargins = expandRows(margins + k * layout.groups, expanded);
    const vfloatV spacing(this->spacing.at[k]), origin(offset), unit(float(1u << marginShift(info, k)));
    const QuadCornersV corners{CellVector(vertices)};
    for (int j = 0; j < QuadCornersV::vectors; j++) {
      const vfloatV c[4] = {corners.at(j, 0), corners.at(j, 1), corners.at(j, 2), corners.at(j, 3)};
      // bits 0 to 3: margin of the lower plane; bits 4 to 7: margin of the upper plane
      const vintV margin = loadBytes(axisMargins + vectorWidth * j);
      vfloatV::store(
          out.at[0] + vectorWidth * j,
          madd(nmadd(vfloatV(margin & vintV(15)), unit, min(min(c[0], c[1]), min(c[2], c[3]))), spacing, origin));
      vfloatV::store(out.at[1] + vectorWidth * j,
                     madd(madd(vfloatV(margin >> 4), unit, max(max(c[0], c[1]), max(c[2], c[3]))), spacing, origin));
    }
  }

  /*! Moves each group's byte to the group's lane. Returns `out`, or `rows` if nothing moves. 20 bytes can be
   *  read from the result. out: 24 bytes. */
  __forceinline const uint8_t* expandRows(const uint8_t* rows, uint8_t* out) const {
    if (likely(layout.groupsX == 4)) return rows;
    for (int i = 0; i < 24; i++) out[i] = 0;
    for (uint32_t y = 0; y < layout.groupsY; y++)
      for (uint32_t x = 0; x < layout.groupsX; x++) out[4 * y + x] = rows[y * layout.groupsX + x];
    return out;
  }

  const uint32_t info;
  const uint8_t* margins;
  const VertLayout& layout;
  const VertSpacing& spacing;
  const float* origin;
};
} // namespace embree::isa::cbvh
