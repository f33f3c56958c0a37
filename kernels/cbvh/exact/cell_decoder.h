// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* SIMD decoder of a cVERT cell (cvert/format/cell.h): prediction from the corners, plus residuals. All numbers are
 * exact in float, so the scalar decoder (cvert/decoder/cell_vertices.h) returns the same values, fused or not. */

#include "quad_corners.h"
#include "cache.h"
#include "../base/codec_names.h"
#include "../../cvert/format/block.h"

namespace embree::isa::cbvh {
/*! Converts x, y and z, 16 bits each, to float. Lane 3 contains the next 16 bits. */
__forceinline vfloat4 coordinatesAt(const void* p) {
  return vfloat4(vint4(_mm_unpacklo_epi16(_mm_loadl_epi64((const __m128i*)p), _mm_setzero_si128())));
}

/*! Loads corner c of VertHeader::corners or VertStep::corners: 14 bits per coordinate, below two other bits
 *  (cornerBits). Lane 3 is undefined. */
__forceinline vfloat4 cornerAt(const uint32_t corners[6], int c) {
  const __m128i coordinates =
      _mm_and_si128(_mm_loadl_epi64((const __m128i*)((const uint16_t*)corners + 3 * c)), _mm_set1_epi16(16383));
  return vfloat4(vint4(_mm_unpacklo_epi16(coordinates, _mm_setzero_si128())));
}

/*! Extracts signed components from bits shift to shift+bits-1 of the fields. Two shifts extend the sign; for 0
 *  bits, the shift by 32 returns 0. */
__forceinline vfloatV componentOf(const vintV& fields, int shift, int bits) {
  return vfloatV((fields << (bits == 0 ? 32 : 32 - bits - shift)) >> (32 - bits));
}

/*! Bilinear prediction from a cell's corners, as cellPrediction() of the codec. */
class CellPrediction {
public:
  __forceinline CellPrediction(const vfloat4& c00, const vfloat4& c10, const vfloat4& c01, const vfloat4& c11) {
    const vfloat4 x = c10 - c00, y = c01 - c00;
    vfloat4::store(constant, c00);
    vfloat4::store(dx, x);
    vfloat4::store(dy, y);
    vfloat4::store(dxy, (c11 - c01) - x);
    vfloat4::store(upperRight, c11);
  }

  /*! Predictions on an axis. x, y: weights of the upper corners (VertTables). */
  __forceinline vfloatV at(int axis, const vfloatV& x, const vfloatV& y) const {
    return vfloatV(constant[axis]) +
           floor(madd(madd(vfloatV(dxy[axis]), y, vfloatV(dx[axis])), x, madd(vfloatV(dy[axis]), y, vfloatV(0.5f))));
  }

  /*! Coordinate of corner 11, the cell's last vertex. */
  __forceinline vfloatV last(int axis) const { return vfloatV(upperRight[axis]); }

private:
  /* By axis: coefficients of constant + dx x + dy y + dxy x y, and corner 11. */
  alignas(16) float constant[4], dx[4], dy[4], dxy[4], upperRight[4];
};

/*! Predictions of a cell, vector by vector: a Base of CellDecoder. */
class CellBase {
public:
  /*! prediction must outlive this object. isGroup: true for a group's cell, false for the block's first cell.
   *  quadsX, quadsY: along the cell's sides. */
  __forceinline CellBase(const CellPrediction& prediction, bool isGroup, uint32_t quadsX, uint32_t quadsY)
    : prediction(prediction),
      weightX(vertTables.weightX[isGroup][quadsX - 1]),
      weightY(vertTables.weightY[isGroup][quadsY - 1]) {}

  __forceinline vfloatV at(int axis, int vector) const {
    return prediction.at(axis, vfloatV::load(weightX + vectorWidth * vector),
                         vfloatV::load(weightY + vectorWidth * vector));
  }
  __forceinline vfloatV last(int axis) const { return prediction.last(axis); }

private:
  const CellPrediction& prediction;
  const float* weightX;
  const float* weightY;
};

/*! Output of CellDecoder: lattice coordinates. */
struct CellLatticeOutput {
  CellVertices& out;

  __forceinline void storeAxis(int axis, const CellVector& v) const {
    for (int n = 0; n < fieldVectors; n++) vfloatV::store(out.at[axis] + vectorWidth * n, v.at[n]);
#if !defined(__AVX512F__)
    vfloatV::store(out.at[axis] + vectorWidth * fieldVectors, v.last);
#endif
  }
};

/*! Output of CellDecoder: world positions. */
struct CellWorldOutput {
  CellVertices& out;
  const VertSpacing& spacing;
  const float* origin;

  __forceinline void storeAxis(int axis, const CellVector& v) const {
    CellLatticeOutput{out}.storeAxis(axis, madd(v, spacing.at[axis], origin[axis]));
  }
};

/*! Decodes a cell. word, data: the cell's word and fields. Base: the numbers to which residuals are added, a
 *  CellBase or a class of motion_decoder.h. Out: CellLatticeOutput or CellWorldOutput. */
template<typename Base>
class CellDecoder {
public:
  __forceinline CellDecoder(uint32_t word, const uint8_t* data, const Base& base)
    : word(word),
      data(data),
      base(base) {}

  template<typename Out>
  __forceinline void decode(const Out& out) const {
    if (unlikely(isByAxis(word))) {
      decodeByAxis(*this, out);
      return;
    }
    const CellFields fields(data, cellFieldBits(word));
    const int second = cellBits(word, 0), third = second + cellBits(word, 1);
    vfloatV main[fieldVectors];
    decodeComponent<0>(fields, 0, main, out);
    decodeComponent<1>(fields, second, main, out);
    decodeComponent<2>(fields, third, main, out);
  }

private:
  /*! Decodes a cell whose residuals are stored as three arrays (isByAxis). A copy of the decoder lets the
   *  caller's members stay in registers. */
  template<typename Out>
  static __noinline void decodeByAxis(const CellDecoder cell, const Out out) {
    const int bits[3] = {cellBits(cell.word, 0), cellBits(cell.word, 1), cellBits(cell.word, 2)};
    vfloatV main[fieldVectors];
    cell.decodeComponent<0>(CellFields(cell.data, bits[0]), 0, main, out);
    cell.decodeComponent<1>(CellFields(cell.data, bits[1], cellFields * bits[0]), 0, main, out);
    cell.decodeComponent<2>(CellFields(cell.data, bits[2], cellFields * (bits[0] + bits[1])), 0, main, out);
  }

  /*! Decodes component i, which starts at bit `shift` of the fields. main: residuals along the main axis, set
   *  by component 0; the others add them, times their slope. */
  template<int i, typename Out>
  __forceinline void decodeComponent(const CellFields& fields, int shift, vfloatV main[fieldVectors],
                                     const Out& out) const {
    const int bits = cellBits(word, i), axis = cellAxis(word, i);
    const vfloatV slope(i == 0 ? 0.0f : float(cellSlope(word, i)) * (1.0f / 16.0f));
    CellVector v(base.last(axis));
    for (int c = 0; c < fieldVectors; c++) {
      vfloatV residual = componentOf(fields.lanes[c], shift, bits);
      if (i == 0) main[c] = residual;
      else residual = residual + floor(madd(slope, main[c], vfloatV(0.5f)));
      v.at[c] = base.at(axis, c) + residual;
    }
    out.storeAxis(axis, v);
  }

  const uint32_t word;
  const uint8_t* data;
  const Base base;
};

template<typename Base, typename Out>
__forceinline void decodeCell(uint32_t word, const uint8_t* data, const Base& base, const Out& out) {
  CellDecoder<Base>(word, data, base).decode(out);
}

/*! Copies the vertices of group (gx,gy) of a raw block or step. from: vertices of the block or step. Quads
 *  outside of the region become degenerate, and are never hit. */
__noinline inline void copyVertices(const void* from, uint32_t region, uint32_t gx, uint32_t gy, CellVertices& out) {
  const float(*v)[3] = (const float(*)[3])from;
  const uint32_t quadsX = vertQuadsX(region), quadsY = vertQuadsY(region);
  for (uint32_t j = 0; j < 5; j++)
    for (uint32_t i = 0; i < 5; i++) {
      const uint32_t x = min(groupQuads * gx + i, quadsX), y = min(groupQuads * gy + j, quadsY);
      for (int k = 0; k < 3; k++) out.at[k][laneOfVertex(i, j)] = v[y * (quadsX + 1) + x][k];
    }
}

/*! Adds remainders to the vertices of group (gx,gy). Scalar, because few blocks have remainders. start: of the
 *  block or step. remainders: the word of remainders. */
__noinline inline void addRemainders(const void* start, uint32_t remainders, const VertSpacing& spacing,
                                     uint32_t region, uint32_t gx, uint32_t gy, CellVertices& vertices) {
  const uint32_t quadsX = vertQuadsX(region), quadsY = vertQuadsY(region);
  for (int k = 0; k < 3; k++) {
    const uint32_t bits = remainderBits(remainders, k);
    if (bits == 0) continue;
    for (uint32_t j = 0; j < 5; j++)
      for (uint32_t i = 0; i < 5; i++) {
        const uint32_t vertex = min(groupQuads * gy + j, quadsY) * (quadsX + 1) + min(groupQuads * gx + i, quadsX);
        const uint32_t bit = remainderBegin(remainders, vertex, k);
        uint64_t word; // extends past the block by less than vertReadPadding
        memcpy(&word, (const uint8_t*)start + (bit >> 3), sizeof(word));
        float& x = vertices.at[k][laneOfVertex(i, j)];
        x = addRemainder(x, uint32_t(word >> (bit & 7u)), bits, spacing.at[k]);
      }
  }
}
} // namespace embree::isa::cbvh
