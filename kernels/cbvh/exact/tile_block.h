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

/*! Where the vertices of one or two leaves are in vectors. With vectors of 16: each leaf in a vector of its own, vertex
 *  (x,y) in lane x + 5 y. Otherwise four neighbors in a row of vertices are a part of a vector, the left ones, 0 to 3,
 * or the right ones, 1 to 4. With vectors of 8: left of rows 0 and 1, right of rows 0 and 1, left and right of row 2.
 * With vectors of 4: left of rows 0, 1 and 2, then right. */
struct LeafLayout {
  static const int vectors = vectorWidth == 16 ? 2 : vectorWidth == 8 ? 3 : 6;

  /*! Lane in all vectors. slot: 1 for the second of two leaves. */
  static constexpr uint32_t laneOf(uint32_t slot, uint32_t x, uint32_t y) {
    const bool isRight = x == leafQuadsX;
    return vectorWidth == 16  ? 16 * slot + x + 5 * y
           : vectorWidth == 8 ? (isRight ? (y == 2 ? 23 : 11 + 4 * y) : x + 4 * y + (y == 2 ? 8 : 0))
                              : (isRight ? 15 : x) + 4 * y;
  }
};

/*! A number per vertex of one or two leaves, by LeafLayout. */
struct LeafVectors {
  vfloatV at[LeafLayout::vectors];

  __forceinline LeafVectors operator-(float x) const {
    LeafVectors r;
    for (int n = 0; n < LeafLayout::vectors; n++) r.at[n] = at[n] - vfloatV(x);
    return r;
  }

  /*! at - factor * other */
  __forceinline LeafVectors shear(float factor, const LeafVectors& other) const {
    LeafVectors r;
    for (int n = 0; n < LeafLayout::vectors; n++) r.at[n] = nmadd(vfloatV(factor), other.at[n], at[n]);
    return r;
  }
};

/*! The same numbers at corners of quads, with one quad per lane: quad (column,row) of a leaf in lane column + 4 row,
 *  the second leaf's from lane 8. */
struct LeafCorners {
  vfloatV at[tileQuadVectors][4]; //!< corner c (column + 2 row)

  __forceinline explicit LeafCorners(const LeafVectors& vertices) { set(vertices.at); }

private:
  __forceinline void set(const vfloatV v[LeafLayout::vectors]) {
#if defined(__AVX512F__)
    const __m512i lower = _mm512_setr_epi32(0, 1, 2, 3, 5, 6, 7, 8, 16, 17, 18, 19, 21, 22, 23, 24);
    const int distance[4] = {0, 1, 5, 6};
    for (int c = 0; c < 4; c++)
      at[0][c] = _mm512_permutex2var_ps(v[0], _mm512_add_epi32(lower, _mm512_set1_epi32(distance[c])), v[1]);
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

class TileBlock {
public:
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
    vfloat4::store(base, vfloat4::load(base) * vfloat4(float(tileScale(tile))));
    vfloat4::store(spacing, spacingsOfTile(tile));
    const uint32_t bits = tile->word;
    shift[0] = 0;
    shift[1] = bits & 31u;
    shift[2] = shift[1] + ((bits >> 5) & 31u);
    for (int k = 0; k < 3; k++) mask[k] = (1u << ((bits >> (5 * k)) & 31u)) - 1u;
  }

  /*! Sets out[i] to the vertices of leaves on axis axes[i], in world space. */
  __forceinline void vertices(const uint32_t leaves[tileLeavesAtOnce], const int axes[3], LeafVectors out[3]) const {
    if (unlikely(bytes == tileFloatBytes)) loadFloats(leaves, axes, out);
    else decode(leaves, axes, out);
  }

  /*! See leafFlip. */
  __forceinline uint32_t flip(uint32_t octant) const { return leafFlip(tile, octant); }

  const VertHeader* const tile;

private:
  /*! Bits per vertex of one or two leaves. */
  struct LeafBits {
    vintV at[LeafLayout::vectors];
  };

  __forceinline uint32_t firstVertex(uint32_t leaf) const {
    return leafQuadsY * (leaf >> 2) * row + leafQuadsX * (leaf & 3u);
  }

  /*! By how much the upper bytes of vertices of 5 bytes are shifted: 32 on axes that they do not reach. */
  __forceinline int topShift(int axis) const { return axis == 2 ? 32 - int(shift[2]) : 32; }

  __forceinline void loadFloats(const uint32_t leaves[tileLeavesAtOnce], const int axes[3], LeafVectors out[3]) const {
    for (int i = 0; i < 3; i++) {
      const float* const plane = (const float*)data + uint32_t(axes[i]) * row * tileRows(tile->region);
      LeafBits bits;
      loadWords(leaves, (const uint8_t*)plane, bits);
      for (int n = 0; n < LeafLayout::vectors; n++) out[i].at[n] = asFloat(bits.at[n]);
    }
  }

  __forceinline void decode(const uint32_t leaves[tileLeavesAtOnce], const int axes[3], LeafVectors out[3]) const {
    LeafBits low, top;
    const bool hasTop = bytes == 5, isShort = bytes < 4;
    if (isShort) loadShort(leaves, low);
    else loadWords(leaves, data, low);
    if (unlikely(hasTop)) loadTop(leaves, top);
    const Prediction prediction(leaves);
    for (int i = 0; i < 3; i++) {
      const int k = axes[i];
      const vfloatV scale(spacing[k]), origin(tile->origin[k]);
      const vintV used((int)mask[k]);
      LeafVectors predicted;
      prediction.set(slopeX[k], slopeY[k], base[k], predicted);
      for (int n = 0; n < LeafLayout::vectors; n++) {
        vintV residual = shifted(low.at[n], int(shift[k]));
        if (unlikely(hasTop)) residual = residual | sll(top.at[n], topShift(k));
        out[i].at[n] = madd(vfloatV(residual & used) + predicted.at[n], scale, origin);
      }
    }
  }

#if defined(__AVX512F__)
  /*! A vertex per lane, from words of 4 bytes. Loads of 32 bytes, because those of 64 bytes with a mask nearly always
   *  touch two lines of the cache. */
  __forceinline void loadWords(const uint32_t leaves[2], const uint8_t* from, LeafBits& out) const {
    const __m512i pick = _mm512_setr_epi32(0, 1, 2, 3, 4, 8, 9, 10, 11, 12, 16, 17, 18, 19, 20, 20);
    for (int l = 0; l < 2; l++) {
      const uint8_t* const first = from + 4 * firstVertex(leaves[l]);
      auto rowAt = [&](uint32_t y) { return _mm256_loadu_si256((const __m256i*)(first + 4 * y * row)); };
      const __m512i rows = _mm512_inserti64x4(_mm512_castsi256_si512(rowAt(0)), rowAt(1), 1);
      out.at[l] = _mm512_permutex2var_epi32(rows, pick, _mm512_castsi256_si512(rowAt(2)));
    }
  }

  /*! Of 2 or 3 bytes. Those of 3 bytes in odd columns are 8 bits higher, see shifted(). */
  __forceinline void loadShort(const uint32_t leaves[2], LeafBits& out) const {
    const __m512i pick = _mm512_loadu_si512(shortWords[bytes - 2]);
    for (int l = 0; l < 2; l++) {
      const uint8_t* const first = data + bytes * firstVertex(leaves[l]);
      auto rowAt = [&](uint32_t y) { return _mm_loadu_si128((const __m128i*)(first + y * bytes * row)); };
      __m512i v = _mm512_castsi128_si512(rowAt(0));
      v = _mm512_inserti32x4(v, rowAt(1), 1);
      v = _mm512_inserti32x4(v, rowAt(2), 2);
      out.at[l] = _mm512_permutexvar_epi16(pick, v);
    }
  }

  __forceinline void loadTop(const uint32_t leaves[2], LeafBits& out) const {
    for (int l = 0; l < 2; l++) {
      const uint8_t* const first = high + firstVertex(leaves[l]);
      uint64_t rows[3];
      for (uint32_t y = 0; y < 3; y++) {
        memcpy(&rows[y], first + y * row, 8);
        rows[y] &= 0xFFFFFFFFFFu;
      }
      out.at[l] = _mm512_cvtepu8_epi32(
          _mm_set_epi64x(int64_t(rows[1] >> 24 | rows[2] << 16), int64_t(rows[0] | rows[1] << 40)));
    }
  }

  __forceinline vintV shifted(const vintV& bits, int count) const {
    return _mm512_srlv_epi32(bits,
                             _mm512_add_epi32(_mm512_set1_epi32(count), _mm512_load_si512(oddShifts[bytes == 3])));
  }

  struct Prediction {
    vfloatV x[2], y[2];

    __forceinline explicit Prediction(const uint32_t leaves[2]) {
      for (int l = 0; l < 2; l++) {
        x[l] = vfloatV::load(columns) + vfloatV(float(leafQuadsX * (leaves[l] & 3u)));
        y[l] = vfloatV::load(rows) + vfloatV(float(leafQuadsY * (leaves[l] >> 2)));
      }
    }

    __forceinline void set(float slopeX, float slopeY, float base, LeafVectors& out) const {
      for (int l = 0; l < 2; l++) out.at[l] = madd(x[l], vfloatV(slopeX), madd(y[l], vfloatV(slopeY), vfloatV(base)));
    }

    alignas(64) static constexpr float columns[16] = {0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0};
    alignas(64) static constexpr float rows[16] = {0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2};
  };

  /*! [bytes == 3][lane] */
  alignas(64) static constexpr int oddShifts[2][16] = {{}, {0, 8, 0, 8, 0, 0, 8, 0, 8, 0, 0, 8, 0, 8, 0, 0}};

  /*! Pairs of words of 2 bytes that contain the vertices, in three rows of 8 words. [bytes - 2][lane] */
  alignas(64) static constexpr uint16_t shortWords[2][32] = {
      {0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 8, 9, 9, 10, 10, 11, 11, 12, 12, 13, 16, 17, 17, 18, 18, 19, 19, 20, 20, 21, 0, 0},
      {0,  1,  1,  2,  3,  4,  4,  5,  6,  7,  8,  9,  9,  10, 11, 12,
       12, 13, 14, 15, 16, 17, 17, 18, 19, 20, 20, 21, 22, 23, 0,  0}};
#else
  /*! Calls f(n, part, row, side) for the parts of all vectors. */
  template<typename Function>
  static __forceinline void forEachPart(const Function& f) {
#if defined(__AVX__)
    f(0, 0, 0u, 0u);
    f(0, 1, 1u, 0u);
    f(1, 0, 0u, 1u);
    f(1, 1, 1u, 1u);
    f(2, 0, 2u, 0u);
    f(2, 1, 2u, 1u);
#else
    for (uint32_t y = 0; y < 3; y++) {
      f(int(y), 0, y, 0u);
      f(int(3 + y), 0, y, 1u);
    }
#endif
  }

  /*! load(v): returns a part whose first vertex is v. */
  template<typename Load>
  __forceinline void load(uint32_t leaf, LeafBits& out, const Load& load) const {
    const uint32_t first = firstVertex(leaf);
    __m128i parts[LeafLayout::vectors][vectorWidth / 4];
    forEachPart([&](int n, int part, uint32_t y, uint32_t side) { parts[n][part] = load(first + y * row + side); });
    for (int n = 0; n < LeafLayout::vectors; n++) {
#if defined(__AVX__)
      out.at[n] = vintV(vint4(parts[n][0]), vint4(parts[n][1]));
#else
      out.at[n] = vintV(parts[n][0]);
#endif
    }
  }

  __forceinline void loadWords(const uint32_t* leaf, const uint8_t* from, LeafBits& out) const {
    load(*leaf, out, [&](uint32_t v) { return _mm_loadu_si128((const __m128i*)(from + 4 * v)); });
  }

  /*! Of 2 or 3 bytes. */
  __forceinline void loadShort(const uint32_t* leaf, LeafBits& out) const {
    if (likely(bytes == 3)) load(*leaf, out, [&](uint32_t v) { return loadTriples(data + 3 * v); });
    else load(*leaf, out, [&](uint32_t v) { return extend16(_mm_loadl_epi64((const __m128i*)(data + 2 * v))); });
  }

  __forceinline void loadTop(const uint32_t* leaf, LeafBits& out) const {
    load(*leaf, out, [&](uint32_t v) { return extend8(loadFour(high + v)); });
  }

  static __forceinline vintV shifted(const vintV& bits, int count) { return srl(bits, count); }

  struct Prediction {
    vfloatV x, y;

    __forceinline explicit Prediction(const uint32_t* leaf)
      : x(vfloatV::load(columns) + vfloatV(float(leafQuadsX * (*leaf & 3u)))),
        y(float(leafQuadsY * (*leaf >> 2))) {}

    __forceinline void set(float slopeX, float slopeY, float base, LeafVectors& out) const {
      const vfloatV dx(slopeX), dy(slopeY), start = madd(y, dy, vfloatV(base));
#if defined(__AVX__)
      const vfloatV second = vfloatV::load(isSecond);
      out.at[0] = madd(x, dx, madd(second, dy, start));
      out.at[1] = out.at[0] + dx;
      out.at[2] = madd(x + second, dx, madd(vfloatV(2.0f), dy, start));
#else
      out.at[0] = madd(x, dx, start);
      for (int n = 1; n < LeafLayout::vectors; n++) out.at[n] = n == 3 ? out.at[0] + dx : out.at[n - 1] + dy;
#endif
    }

    alignas(32) static constexpr float columns[8] = {0, 1, 2, 3, 0, 1, 2, 3};
    alignas(32) static constexpr float isSecond[8] = {0, 0, 0, 0, 1, 1, 1, 1};
  };
#endif

  const uint32_t bytes, row;
  const uint8_t *const data, *const high; //!< vertices; upper bytes of vertices of 5 bytes
  alignas(16) float slopeX[4], slopeY[4], base[4], spacing[4];
  uint32_t shift[3], mask[3];
};

/*! Lanes of the vertices of a leaf's triangles. */
struct LeafTriangleLanes {
  static const uint32_t triangles = 2 * leafQuadsX * leafQuadsY;

  /*! [second leaf][2 (column + 4 row) of the quad + 1 for the second triangle] */
  uint8_t at[tileLeavesAtOnce][triangles][3];

  constexpr LeafTriangleLanes() : at() {
    for (uint32_t slot = 0; slot < uint32_t(tileLeavesAtOnce); slot++)
      for (uint32_t i = 0; i < triangles; i++) {
        const uint32_t x = (i >> 1) % leafQuadsX, y = (i >> 1) / leafQuadsX, second = i & 1u;
        at[slot][i][0] = uint8_t(LeafLayout::laneOf(slot, x, y + second));
        at[slot][i][1] = uint8_t(LeafLayout::laneOf(slot, x + 1, y));
        at[slot][i][2] = uint8_t(LeafLayout::laneOf(slot, x + second, y + 1));
      }
  }
};
static constexpr LeafTriangleLanes leafTriangleLanes;
} // namespace embree::isa::cbvh
