// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a cVERT cell in registers, and the corners of its 4 x 4 quads with one quad per lane. The lower left
 * corners are the first 16 vertices in the order of laneOfVertex; other corners are shifted by a column, a row or
 * both. */

#include "cell_fields.h"
#include "../base/intrinsics.h"

namespace embree::isa::cbvh {
/*! A number per vertex of a cell. With AVX-512, all 25 vertices fit into two vectors. */
struct CellVector {
  vfloatV at[fieldVectors];
#if !defined(__AVX512F__)
  vfloatV last; //!< last vertex, in all lanes
#endif

  __forceinline CellVector() {}

  /*! Sets only the last vertex. With AVX-512 sets nothing: the last vertex is a lane of at[1]. */
#if defined(__AVX512F__)
  __forceinline explicit CellVector(const vfloatV&) {}
#else
  __forceinline explicit CellVector(const vfloatV& last) : last(last) {}
#endif

  /*! p: 25 numbers, padded and aligned for vector loads. */
  __forceinline explicit CellVector(const float* p) {
    for (int n = 0; n < fieldVectors; n++) at[n] = vfloatV::load(p + vectorWidth * n);
#if !defined(__AVX512F__)
    last = vfloatV(p[cellVertices - 1]);
#endif
  }

  template<typename Function>
  static __forceinline CellVector combine(const CellVector& a, const CellVector& b, const Function& f) {
    CellVector r;
    for (int n = 0; n < fieldVectors; n++) r.at[n] = f(a.at[n], b.at[n]);
#if !defined(__AVX512F__)
    r.last = f(a.last, b.last);
#endif
    return r;
  }

  template<typename Function>
  __forceinline CellVector map(const Function& f) const {
    CellVector r;
    for (int n = 0; n < fieldVectors; n++) r.at[n] = f(at[n]);
#if !defined(__AVX512F__)
    r.last = f(last);
#endif
    return r;
  }
};

__forceinline CellVector madd(const CellVector& a, float b, float c) {
  return a.map([&](const vfloatV& x) { return madd(x, vfloatV(b), vfloatV(c)); });
}

/*! One coordinate of the corners of 4 x 4 quads. Quad (x,y) is in lane x + 4 y of the vectors. */
class QuadCornersV {
public:
  static const int vectors = 16 / vectorWidth;

#if defined(__AVX512F__)
  __forceinline explicit QuadCornersV(const CellVector& v) : left(v) {
    right = _mm512_permutex2var_ps(v.at[0], _mm512_setr_epi32(1, 2, 3, 20, 5, 6, 7, 21, 9, 10, 11, 22, 13, 14, 15, 23),
                                   v.at[1]);
    upperRight = _mm512_permutex2var_ps(
        v.at[0], _mm512_setr_epi32(5, 6, 7, 21, 9, 10, 11, 22, 13, 14, 15, 23, 17, 18, 19, 24), v.at[1]);
  }

  /*! at(j,c): corner c (column + 2 row) of the quads in vector j. */
  __forceinline vfloatV at(int, int c) const {
    return c == 0   ? left.at[0]
           : c == 1 ? right
           : c == 3 ? upperRight
                    : vfloatV(_mm512_castsi512_ps(
                          _mm512_alignr_epi32(_mm512_castps_si512(left.at[1]), _mm512_castps_si512(left.at[0]), 4)));
  }

private:
  CellVector left; //!< vertices in their own lanes: corners 0
  vfloatV right, upperRight;

#elif defined(__AVX__)
  __forceinline explicit QuadCornersV(const CellVector& v) : left(v) {
    const __m256 column = _mm256_permute2f128_ps(v.at[2], v.at[2], 0x11);
    right[0] = insertFourth(v.at[0], _mm256_permutevar_ps(column, _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1)));
    right[1] = insertFourth(v.at[1], _mm256_permutevar_ps(column, _mm256_setr_epi32(2, 2, 2, 2, 3, 3, 3, 3)));
    right[2] = insertFourth(v.at[2], v.last);
  }

  __forceinline vfloatV at(int j, int c) const {
    const vfloatV* side = c & 1 ? right : left.at;
    return c & 2 ? vfloatV(_mm256_permute2f128_ps(side[j], side[j + 1], 0x21)) : side[j];
  }

private:
  /*! Drops the first vertex of each of two rows, and inserts lanes 3 and 7 of `last` as their last ones. */
  static __forceinline vfloatV insertFourth(const vfloatV& rows, const vfloatV& last) {
    return _mm256_blend_ps(_mm256_permute_ps(rows, _MM_SHUFFLE(0, 3, 2, 1)), last, 0x88);
  }

  CellVector left;
  vfloatV right[3];
#else
  __forceinline explicit QuadCornersV(const CellVector& v) : left(v) {
    right[0] = dropFirstAndAppend<0>(v.at[0], v.at[5]);
    right[1] = dropFirstAndAppend<1>(v.at[1], v.at[5]);
    right[2] = dropFirstAndAppend<2>(v.at[2], v.at[5]);
    right[3] = dropFirstAndAppend<3>(v.at[3], v.at[5]);
    right[4] = dropFirstAndAppend<0>(v.at[4], v.last);
  }

  __forceinline vfloatV at(int j, int c) const { return (c & 1 ? right : left.at)[j + (c >> 1)]; }

private:
  CellVector left;
  vfloatV right[5];
#endif
};
} // namespace embree::isa::cbvh
