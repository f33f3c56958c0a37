// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* SIMD extraction of the bit fields of a cVERT cell (cvert/format/cell.h). With AVX-512, two permutations select the
 * words of each field; otherwise a byte shuffle per row of vertices (VertTables::Windows), or else a scalar loop. */

#include "tables.h"
#include "../base/intrinsics.h"
#include "../base/vectors.h"
#include "../base/codec_names.h"
#include "../../cvert/format/cell.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

/*! Numbers of vectors: for all vertices of a cell, and for all but the last one. The last one has no field, but
 *  would need another vector of 4 or 8 lanes. */
static const int cellVectors = (cellVertices + vectorWidth - 1) / vectorWidth;
static const int fieldVectors = (cellVertices - 1 + vectorWidth - 1) / vectorWidth;

/*! Fields of a cell, one per lane. Bits above a field are undefined. Lanes without a field are 0. */
struct CellFields {
  vintV lanes[fieldVectors];

  /*! data: start of the cell's fields. bits: per field. start: first bit of the first field. Reads up to 8
   *  bytes after the last field. */
  __forceinline CellFields(const uint8_t* data, int bits, int start = 0) {
#if defined(__AVX512F__)
    const int words = (start + cellFields * bits + 31) >> 5; // at most 30, for 21 residuals of 3 times 15 bits
    const __mmask16 low = words < 16 ? __mmask16((1u << words) - 1) : __mmask16(0xFFFF);
    const __mmask16 high = words < 16 ? __mmask16(0) : __mmask16((1u << (words - 16)) - 1);
    const __m512i a = _mm512_maskz_loadu_epi32(low, data), b = _mm512_maskz_loadu_epi32(high, data + 64);
    for (int c = 0; c < fieldVectors; c++) {
      const __m512i bit = _mm512_add_epi32(
          _mm512_mullo_epi32(_mm512_load_si512((const void*)(vertTables.field + 16 * c)), _mm512_set1_epi32(bits)),
          _mm512_set1_epi32(start));
      const __m512i word = _mm512_srli_epi32(bit, 5), shift = _mm512_and_si512(bit, _mm512_set1_epi32(31));
      const __m512i first = _mm512_permutex2var_epi32(a, word, b);
      const __m512i second = _mm512_permutex2var_epi32(a, _mm512_add_epi32(word, _mm512_set1_epi32(1)), b);
      // a field can extend into a second word; if it starts at bit 0, the shift by 32 returns 0
      lanes[c] = _mm512_or_si512(_mm512_srlv_epi32(first, shift),
                                 _mm512_sllv_epi32(second, _mm512_sub_epi32(_mm512_set1_epi32(32), shift)));
      lanes[c] = lanes[c] & vintV::load(vertTables.hasField + 16 * c);
    }
#else
#if defined(CBVH_SSE41_INTEGERS)
    if (likely(start == 0 && VertTables::hasWindows(bits))) {
      const VertTables::Windows& windows = vertTables.windows[bits];
      if (likely(bits <= VertTables::maxFourByteBits)) {
        for (int c = 0; c < fieldVectors; c++) lanes[c] = fieldsOfVector<false>(data, windows, c);
        return;
      }
#if defined(CBVH_VARIABLE_SHIFTS)
      for (int c = 0; c < fieldVectors; c++) lanes[c] = fieldsOfVector<true>(data, windows, c);
      return;
#endif
    }
#endif
    alignas(64) uint32_t fields[VertTables::lanes];
    fields[laneOfVertex(0, 0)] = fields[laneOfVertex(4, 0)] = fields[laneOfVertex(0, 4)] = fields[laneOfVertex(4, 4)] =
        0;
    for (int l = cellVertices; l < VertTables::lanes; l++) fields[l] = 0;
    for (int f = 0, bit = start; f < cellFields; f++, bit += bits) {
      uint64_t word;
      memcpy(&word, data + (bit >> 3), sizeof(word));
      fields[vertTables.laneOfField[f]] = uint32_t(word >> (bit & 7));
    }
    for (int c = 0; c < fieldVectors; c++) lanes[c] = vintV::load((int*)fields + vectorWidth * c);
#endif
  }

private:
#if defined(CBVH_SSE41_INTEGERS) && !defined(__AVX512F__)
  static __forceinline __m128i loadWindow(const uint8_t* data, const VertTables::Windows& windows, int row,
                                          const uint8_t (*shuffle)[16]) {
    return _mm_shuffle_epi8(_mm_loadu_si128((const __m128i*)(data + windows.offset[row])),
                            _mm_load_si128((const __m128i*)shuffle[row]));
  }

  /*! Fields of a row's first four columns, of up to maxFourByteBits bits. */
  static __forceinline vint4 fieldsOfRow(const uint8_t* data, const VertTables::Windows& windows, int row) {
    return _mm_srli_epi32(_mm_mullo_epi32(loadWindow(data, windows, row, windows.shuffle),
                                          _mm_load_si128((const __m128i*)(windows.factor + 4 * row))),
                          7);
  }

  /*! Fields of the fifth column's first four vertices. The first one is a corner and has none. */
  static __forceinline vint4 fieldsOfColumn(const uint8_t* data, const VertTables::Windows& windows) {
    auto field = [&](int row) {
      uint64_t word;
      memcpy(&word, data + windows.columnOffset[row], sizeof(word));
      return int(word >> windows.columnShift[row]);
    };
    return _mm_insert_epi32(_mm_insert_epi32(_mm_insert_epi32(_mm_setzero_si128(), field(1), 1), field(2), 2), field(3),
                            3);
  }

  /*! fieldsOfRow for fields that can extend over five bytes. */
  static __forceinline vint4 fieldsOfWideRow(const uint8_t* data, const VertTables::Windows& windows, int row) {
#if defined(CBVH_VARIABLE_SHIFTS)
    const __m128i shift = _mm_load_si128((const __m128i*)(windows.shift + 4 * row));
    // shifts by 32 return 0
    return _mm_or_si128(_mm_srlv_epi32(loadWindow(data, windows, row, windows.shuffle), shift),
                        _mm_sllv_epi32(loadWindow(data, windows, row, windows.shuffleFifthByte),
                                       _mm_sub_epi32(_mm_set1_epi32(32), shift)));
#else
    return fieldsOfRow(data, windows, row); // unreachable: the constructor requires CBVH_VARIABLE_SHIFTS
#endif
  }

  /*! Lanes 4 i to 4 i + 3. wide: fields can extend over five bytes. */
  template<bool wide>
  static __forceinline vint4 fieldsOfFour(const uint8_t* data, const VertTables::Windows& windows, int i) {
    return i == VertTables::Windows::rows ? fieldsOfColumn(data, windows)
           : wide                         ? fieldsOfWideRow(data, windows, i)
                                          : fieldsOfRow(data, windows, i);
  }

  template<bool wide>
  static __forceinline vintV fieldsOfVector(const uint8_t* data, const VertTables::Windows& windows, int c) {
#if defined(__AVX__)
    return vintV(fieldsOfFour<wide>(data, windows, 2 * c), fieldsOfFour<wide>(data, windows, 2 * c + 1));
#else
    return fieldsOfFour<wide>(data, windows, c);
#endif
  }
#endif
};
} // namespace embree::isa::cbvh
