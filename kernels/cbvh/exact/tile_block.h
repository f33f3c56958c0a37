// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Access to a tile (cvert/format/tile.h) with vector instructions, without a cache: the vertices of a leaf or two, and
 * those of a triangle. Vertices are the same floats as tileVertex() returns. */

#include "../base/codec_names.h"
#include "../base/intrinsics.h"
#include "../base/vectors.h"
#include "../../cvert/format/tile.h"
#include "quad_corners.h"
#include "triangles.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

/*! Leaves that are tested at a time, and vectors of their quads: as many as fit into a vector. */
static const int tileLeavesAtOnce = vectorWidth == 16 ? 2 : 1;
static const int tileQuadVectors = vectorWidth == 4 ? 2 : 1;

/*! Quads per row of a leaf fill four lanes, here called a part of a vector. */
static const int tilePartsOfVector = vectorWidth / 4;

/*! Concatenates the parts of a vector. */
__forceinline vintV joinParts(const __m128i (&parts)[tilePartsOfVector]) {
#if defined(__AVX512F__)
  const __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(parts[0]), parts[1], 1);
  const __m256i high = _mm256_inserti128_si256(_mm256_castsi128_si256(parts[2]), parts[3], 1);
  return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
#elif defined(__AVX__)
  return vintV(vint4(parts[0]), vint4(parts[1]));
#else
  return vintV(parts[0]);
#endif
}

/*! Moves 3 bytes to each lane. Reads 16 bytes. */
__forceinline __m128i loadTriples(const uint8_t* p) {
#if defined(CBVH_SSE41_INTEGERS)
  return _mm_shuffle_epi8(_mm_loadu_si128((const __m128i*)p),
                          _mm_setr_epi8(0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1));
#else
  return _mm_unpacklo_epi64(_mm_unpacklo_epi32(loadFour(p), loadFour(p + 3)),
                            _mm_unpacklo_epi32(loadFour(p + 6), loadFour(p + 9)));
#endif
}

/*! Spacings on x, y and z. The fourth lane is undefined. */
__forceinline vfloat4 spacingsOfTile(const VertHeader* tile) {
  return vfloat4(_mm_castsi128_ps(_mm_slli_epi32(extend8(loadFour((const uint8_t*)tile + tileSpacingOffset)), 23)));
}

class TileBlock {
public:
  static const bool isMesh = false; //!< see hits1.h

  /*! A number per vertex of one or two leaves. A part of a vector has four neighbors in a row of vertices: the left
   *  ones, 0 to 3, or the right ones, 1 to 4. With vectors of 8, or 16 for two leaves: left of rows 0 and 1, right of
   *  rows 0 and 1, left and right of row 2. With vectors of 4: left of rows 0, 1 and 2, then right. */
  static const int rowVectors = vectorWidth == 4 ? 6 : 3;
  struct RowVectors {
    vfloatV at[rowVectors];

    __forceinline RowVectors operator-(float x) const {
      RowVectors r;
      for (int n = 0; n < rowVectors; n++) r.at[n] = at[n] - vfloatV(x);
      return r;
    }

    /*! at - factor * other */
    __forceinline RowVectors shear(float factor, const RowVectors& other) const {
      RowVectors r;
      for (int n = 0; n < rowVectors; n++) r.at[n] = nmadd(vfloatV(factor), other.at[n], at[n]);
      return r;
    }
  };

  /*! The same numbers at corners of quads, with one quad per lane. */
  struct Corners {
    vfloatV at[tileQuadVectors][4]; //!< corner c (column + 2 row)

    __forceinline explicit Corners(const RowVectors& rows) { set(rows.at); }

  private:
    __forceinline void set(const vfloatV v[rowVectors]) {
#if defined(__AVX512F__)
      at[0][0] = v[0];
      at[0][1] = v[1];
      // row 1 of each leaf, then row 2
      at[0][2] = _mm512_permutex2var_ps(
          v[0], _mm512_setr_epi32(4, 5, 6, 7, 16, 17, 18, 19, 12, 13, 14, 15, 24, 25, 26, 27), v[2]);
      at[0][3] = _mm512_permutex2var_ps(
          v[1], _mm512_setr_epi32(4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31), v[2]);
#elif defined(__AVX__)
      at[0][0] = v[0];
      at[0][1] = v[1];
      at[0][2] = _mm256_permute2f128_ps(v[0], v[2], 0x21);
      at[0][3] = _mm256_permute2f128_ps(v[1], v[2], 0x31);
#else
      for (int n = 0; n < 2; n++) {
        at[n][0] = v[n];
        at[n][1] = v[3 + n];
        at[n][2] = v[n + 1];
        at[n][3] = v[4 + n];
      }
#endif
    }
  };

  __forceinline explicit TileBlock(const VertHeader* tile)
    : tile(tile),
      bytes(tileVertexBytes(tile)),
      row(tileRowVertices(tile->region)),
      data((const uint8_t*)tile + tileVerticesOffset(tile->region, tile->info)),
      high(data + 4 * row * tileRows(tile->region)) {
    const uint8_t* const header = (const uint8_t*)tile;
    auto store16 = [&](uint32_t offset, float out[4]) {
      const __m128i values = _mm_loadl_epi64((const __m128i*)(header + offset));
      vfloat4::store(out, vfloat4(vint4(_mm_srai_epi32(_mm_unpacklo_epi16(values, values), 16))));
    };
    store16(tileSlopeXOffset, slopeX);
    store16(tileSlopeYOffset, slopeY);
    store16(tileBaseOffset, base);
    vfloat4::store(spacing, spacingsOfTile(tile));
    const uint32_t bits = tile->word;
    shift[0] = 0;
    shift[1] = bits & 31u;
    shift[2] = shift[1] + ((bits >> 5) & 31u);
    topShift[0] = topShift[1] = 32;
    topShift[2] = 32 - shift[2];
    for (int k = 0; k < 3; k++) mask[k] = (1u << ((bits >> (5 * k)) & 31u)) - 1u;
    setOffsets();
  }

  /*! Sets out[i] to the vertices of leaves on axis axes[i], in world space. */
  __forceinline void vertices(const uint32_t leaves[tileLeavesAtOnce], const int axes[3], RowVectors out[3]) const {
    if (unlikely(bytes == tileFloatBytes)) loadFloats(leaves, axes, out);
    else decode(leaves, axes, out);
  }

  /*! Vertices of a triangle. g: lane of the group of 4 x 4 quads, index: of the triangle in the group, as for blocks.
   */
  __forceinline VertTriangle triangle(uint32_t g, uint32_t index) const {
    const uint32_t x = groupQuads * (g & 3u) + quadXOfTriangle(index),
                   y = groupQuads * (g >> 2) + quadYOfTriangle(index);
    const uint32_t second = index & 1u;
    // vertices (x, y + second), (x + 1, y), (x + second, y + 1)
    const uint32_t at = y * row + x, a = at + (second ? row : 0), b = at + 1, c = at + row + second;
    vfloat4 v[3];
    if (unlikely(bytes == tileFloatBytes)) {
      const float* plane = (const float*)data;
      for (int k = 0; k < 3; k++, plane += row * tileRows(tile->region))
        v[k] = vfloat4(plane[a], plane[b], plane[c], plane[a]);
      return VertTriangle(v);
    }
    const uint32_t stride = min(bytes, 4u);
    const vint4 low = fields(loadFour(data + stride * a), loadFour(data + stride * b), loadFour(data + stride * c));
    const vfloat4 column = vfloat4(float(x)) + vfloat4(0.0f, 1.0f, float(second), 0.0f),
                  line = vfloat4(float(y)) + vfloat4(float(second), 0.0f, 1.0f, float(second));
    for (int k = 0; k < 3; k++) {
      vint4 residual = srl(low, int(shift[k]));
      if (unlikely(bytes == 5)) residual = residual | sll(vint4(high[a], high[b], high[c], high[a]), int(topShift[k]));
      const vfloat4 coordinate = vfloat4(residual & vint4(int(mask[k]))) +
                                 madd(column, vfloat4(slopeX[k]), madd(line, vfloat4(slopeY[k]), vfloat4(base[k])));
      v[k] = madd(coordinate, vfloat4(spacing[k]), vfloat4(tile->origin[k]));
    }
    return VertTriangle(v);
  }

  const VertHeader* const tile;

private:
  /*! Calls f(n, part, leaf, row, side) for the parts of all vectors. */
  template<typename Function>
  static __forceinline void forEachPart(const Function& f) {
#if defined(__AVX__)
    for (int leaf = 0; leaf < tileLeavesAtOnce; leaf++) {
      f(0, 2 * leaf, leaf, 0u, 0u);
      f(0, 2 * leaf + 1, leaf, 1u, 0u);
      f(1, 2 * leaf, leaf, 0u, 1u);
      f(1, 2 * leaf + 1, leaf, 1u, 1u);
      f(2, 2 * leaf, leaf, 2u, 0u);
      f(2, 2 * leaf + 1, leaf, 2u, 1u);
    }
#else
    for (uint32_t r = 0; r < 3; r++) {
      f(int(r), 0, 0, r, 0u);
      f(int(3 + r), 0, 0, r, 1u);
    }
#endif
  }

  __forceinline uint32_t firstVertex(uint32_t leaf) const {
    return leafQuadsY * (leaf >> 2) * row + leafQuadsX * (leaf & 3u);
  }

  /*! Fields of three vertices. Bits above a field are undefined. */
  static __forceinline vint4 fields(__m128i a, __m128i b, __m128i c) {
    return _mm_unpacklo_epi64(_mm_unpacklo_epi32(a, b), c);
  }

  template<typename Load>
  __forceinline void load(const uint32_t leaves[tileLeavesAtOnce], vintV out[rowVectors], const Load& load) const {
    uint32_t first[tileLeavesAtOnce];
    for (int l = 0; l < tileLeavesAtOnce; l++) first[l] = firstVertex(leaves[l]);
    __m128i parts[rowVectors][tilePartsOfVector];
    forEachPart([&](int n, int part, int leaf, uint32_t r, uint32_t side) {
      parts[n][part] = load(first[leaf] + r * row + side);
    });
    for (int n = 0; n < rowVectors; n++) out[n] = joinParts(parts[n]);
  }

  __forceinline void loadFloats(const uint32_t leaves[tileLeavesAtOnce], const int axes[3], RowVectors out[3]) const {
    for (int i = 0; i < 3; i++) {
      const float* const plane = (const float*)data + uint32_t(axes[i]) * row * tileRows(tile->region);
      vintV bits[rowVectors];
      load(leaves, bits, [&](uint32_t v) { return _mm_loadu_si128((const __m128i*)(plane + v)); });
      for (int n = 0; n < rowVectors; n++) out[i].at[n] = asFloat(bits[n]);
    }
  }

  __forceinline void decode(const uint32_t leaves[tileLeavesAtOnce], const int axes[3], RowVectors out[3]) const {
    vintV low[rowVectors], top[rowVectors];
    if (likely(bytes == 3)) load(leaves, low, [&](uint32_t v) { return loadTriples(data + 3 * v); });
    else if (likely(bytes != 2))
      load(leaves, low, [&](uint32_t v) { return _mm_loadu_si128((const __m128i*)(data + 4 * v)); });
    else load(leaves, low, [&](uint32_t v) { return extend16(_mm_loadl_epi64((const __m128i*)(data + 2 * v))); });
    const bool hasTop = bytes == 5;
    if (unlikely(hasTop)) load(leaves, top, [&](uint32_t v) { return extend8(loadFour(high + v)); });
    const Starts starts(leaves);
    for (int i = 0; i < 3; i++) {
      const int k = axes[i];
      const vfloatV dx(slopeX[k]), scale(spacing[k]), origin(tile->origin[k]);
      const vfloatV start = madd(starts.x, dx, starts.y * vfloatV(slopeY[k]));
      vfloatV predicted[rowVectors];
      predicted[0] = start + vfloatV::load(offset[0][k]);
#if defined(__AVX__)
      predicted[1] = predicted[0] + dx;
      predicted[2] = start + vfloatV::load(offset[1][k]);
#else
      for (int n = 1; n < rowVectors; n++)
        predicted[n] = n == 3 ? predicted[0] + dx : predicted[n - 1] + vfloatV(slopeY[k]);
#endif
      const vintV used(int(mask[k]));
      for (int n = 0; n < rowVectors; n++) {
        vintV residual = srl(low[n], int(shift[k]));
        if (unlikely(hasTop)) residual = residual | sll(top[n], int(topShift[k]));
        out[i].at[n] = madd(vfloatV(residual & used) + predicted[n], scale, origin);
      }
    }
  }

  /*! Column and row of the first vertex of the leaves. */
  struct Starts {
    vfloatV x, y;

    __forceinline explicit Starts(const uint32_t leaves[tileLeavesAtOnce])
      : x(join(leaves, [](uint32_t leaf) { return float(leafQuadsX * (leaf & 3u)); })),
        y(join(leaves, [](uint32_t leaf) { return float(leafQuadsY * (leaf >> 2)); })) {}

    template<typename Function>
    static __forceinline vfloatV join(const uint32_t leaves[tileLeavesAtOnce], const Function& f) {
#if defined(__AVX512F__)
      return vfloatV(_mm512_insertf32x8(_mm512_set1_ps(f(leaves[0])), _mm256_set1_ps(f(leaves[1])), 1));
#else
      return vfloatV(f(leaves[0]));
#endif
    }
  };

  /*! Sets `offset`. */
  __forceinline void setOffsets() {
    alignas(64) static const float columns[16] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
    alignas(64) static const float isSecond[16] = {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1};
    const vfloatV column = vfloatV::load(columns), second = vfloatV::load(isSecond);
    for (int k = 0; k < 3; k++) {
      const vfloatV dx(slopeX[k]), dy(slopeY[k]), first(base[k]);
#if defined(__AVX__)
      vfloatV::store(offset[0][k], madd(column, dx, madd(second, dy, first)));
      vfloatV::store(offset[1][k], madd(column + second, dx, madd(vfloatV(2.0f), dy, first)));
#else
      vfloatV::store(offset[0][k], madd(column, dx, first));
#endif
    }
  }

  const uint32_t bytes, row;
  const uint8_t *const data, *const high; //!< vertices; upper bytes of vertices of 5 bytes
  alignas(16) float slopeX[4], slopeY[4], base[4], spacing[4];
  /*! Predictions at vertices of the first and, with vectors of 8 or 16, the third vector of rows, relative to a leaf's
   *  first vertex. [vector][axis][lane] */
  alignas(64) float offset[2][3][vectorWidth];
  uint32_t shift[3], topShift[3], mask[3]; //!< topShift: of upper bytes; 32 on axes that they do not reach
};
} // namespace embree::isa::cbvh
