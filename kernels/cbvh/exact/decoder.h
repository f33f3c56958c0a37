// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* SIMD decoder of a cVERT block (cvert/format/block.h): first the data that groups share, then the vertices of one
 * group at a time, for cached_block.h. Vertices are the same floats as in cvert/decoder/decoded_block.h, the scalar
 * reference. */

#include "box_decoder.h"
#include "cell_decoder.h"
#include "../../cvert/format/tile.h"

namespace embree::isa::cbvh {
/*! Decodes the words of groups and the offsets of their fields. low: lower 16 bits of each word. high: the next 8
 *  bits, or null if all are 0. begin: offset of the first group's fields. words, fieldOffsets: output by lane;
 *  words must be aligned to 16 bytes. */
__forceinline void decodeGroupWords(const uint8_t* low, const uint8_t* high, uint32_t begin, const VertLayout& layout,
                                    uint32_t words[16], uint16_t fieldOffsets[16]) {
  if (unlikely(layout.groups != maxVertGroups)) {
    uint32_t at = begin;
    for (uint32_t g = 0; g < layout.groups; g++) {
      uint16_t lower;
      memcpy(&lower, low + 2 * g, sizeof(lower));
      const uint32_t lane = 4 * (g / layout.groupsX) + g % layout.groupsX;
      words[lane] = uint32_t(lower) | (high ? uint32_t(high[g]) << 16 : 0u);
      fieldOffsets[lane] = uint16_t(at);
      at += cellBytes(lower);
    }
    return;
  }
  const __m128i upper = high ? _mm_loadu_si128((const __m128i*)high) : _mm_setzero_si128(), nibble = _mm_set1_epi16(15);
  // offsets are prefix sums of cellBytes()
  __m128i before = _mm_set1_epi16(short(begin));
  for (int half = 0; half < 2; half++) {
    const __m128i lower = _mm_loadu_si128((const __m128i*)(low + 16 * half));
    const __m128i higher =
        half ? _mm_unpackhi_epi8(upper, _mm_setzero_si128()) : _mm_unpacklo_epi8(upper, _mm_setzero_si128());
    _mm_store_si128((__m128i*)(words + 8 * half), _mm_unpacklo_epi16(lower, higher));
    _mm_store_si128((__m128i*)(words + 8 * half + 4), _mm_unpackhi_epi16(lower, higher));
    const __m128i bits =
        _mm_add_epi16(_mm_and_si128(lower, nibble), _mm_add_epi16(_mm_and_si128(_mm_srli_epi16(lower, 4), nibble),
                                                                  _mm_and_si128(_mm_srli_epi16(lower, 8), nibble)));
    const __m128i size =
        _mm_srli_epi16(_mm_add_epi16(_mm_mullo_epi16(bits, _mm_set1_epi16(cellFields)), _mm_set1_epi16(7)), 3);
    __m128i sum = _mm_add_epi16(size, _mm_slli_si128(size, 2));
    sum = _mm_add_epi16(sum, _mm_slli_si128(sum, 4));
    sum = _mm_add_epi16(sum, _mm_slli_si128(sum, 8));
    _mm_storeu_si128((__m128i*)(fieldOffsets + 8 * half), _mm_add_epi16(before, _mm_sub_epi16(sum, size)));
    before = _mm_add_epi16(
        before, _mm_shuffle_epi32(_mm_shufflehi_epi16(sum, _MM_SHUFFLE(3, 3, 3, 3)), _MM_SHUFFLE(3, 3, 3, 3)));
  }
}

class VertDecoder {
public:
  __forceinline VertDecoder(const VertHeader* block)
    : block(block),
      layout(vertLayout(block->region, block->info)),
      quadsX(vertQuadsX(block->region)),
      quadsY(vertQuadsY(block->region)),
      spacing(spacingOf(block->word, block->corners)) {}

  /*! Decodes a block's entry, except for out.block. */
  __forceinline void decode(VertBlockEntry& out) const {
    out.lanes = ((1u << layout.groupsX) - 1) * 0x1111u & ((1u << 4 * layout.groupsY) - 1);
    setAxes(block, out);
    if (unlikely(isRaw(block->info))) {
      for (int k = 0; k < 3; k++) {
        if (isTile(block->info)) setPlanesOfTile(k, out);
        else copyPlanes(k, out);
      }
      return;
    }
    CellVertices corners;
    decodeCorners(corners);
    pack(corners, out.corners);
    PlanesDecoder(block->info, (const uint8_t*)block + layout.margins, layout, spacing, block->origin)
        .decode(corners, out.planes);
    decodeGroupWords(bytes(layout.words), bytes(layout.wordsHigh), layout.cell + cellBytes(block->word), layout,
                     out.words, out.fieldOffsets);
  }

  /*! Decodes the vertices of the group in a lane, in world space. entry: output of decode(). */
  __forceinline void vertices(const VertBlockEntry& entry, uint32_t lane, CellVertices& out) const {
    const uint32_t gx = lane & 3, gy = lane >> 2;
    if (unlikely(isTile(block->info))) {
      copyVerticesOfTile(gx, gy, out);
      return;
    }
    if (unlikely(isRaw(block->info))) {
      copyVertices(bytes(layout.vertices), block->region, gx, gy, out);
      return;
    }
    auto corner = [&](int c) { return coordinatesAt(entry.corners.at[vertTables.corners[lane][c]]); };
    const CellPrediction prediction(corner(0), corner(1), corner(2), corner(3));
    const CellBase base(prediction, true, quadsOfGroup(quadsX, gx), quadsOfGroup(quadsY, gy));
    decodeCell(entry.words[lane], bytes(entry.fieldOffsets[lane]), base, CellWorldOutput{out, spacing, block->origin});
    if (unlikely(hasRemainders(block->info)))
      addRemainders(block, wordAt(block, layout.remainders / 4), spacing, block->region, gx, gy, out);
  }

  /*! Packs coordinates, integers from 0 to 65535, for the cache. */
  static __forceinline void pack(const CellVertices& v, CellCoordinates& out) {
    for (int l = 0; l < cellVertices; l += 4) {
      auto four = [&](int k) { return _mm_cvttps_epi32(_mm_load_ps(v.at[k] + l)); };
      const __m128i xy = _mm_or_si128(four(0), _mm_slli_epi32(four(1), 16)), z = four(2);
      _mm_store_si128((__m128i*)out.at[l], _mm_unpacklo_epi32(xy, z));
      if (l + 2 < cellVertices) _mm_store_si128((__m128i*)out.at[l + 2], _mm_unpackhi_epi32(xy, z));
    }
  }

private:
  __forceinline void decodeCorners(CellVertices& out) const {
    auto corner = [&](int c) { return cornerAt(block->corners, c); };
    const CellPrediction prediction(corner(0), corner(1), corner(2), corner(3));
    decodeCell(block->word, bytes(layout.cell), CellBase(prediction, false, quadsX, quadsY), CellLatticeOutput{out});
  }

  __forceinline const uint8_t* bytes(uint32_t offset) const { return (const uint8_t*)block + offset; }

  /*! Copies the planes of a raw block on axis k, and sets the extent. */
  void copyPlanes(int k, VertBlockEntry& out) const {
    const float* planes = (const float*)bytes(layout.boxes);
    float highest = block->origin[k];
    for (uint32_t l = 0; l < 16; l++) {
      const uint32_t g = min(l >> 2, layout.groupsY - 1) * layout.groupsX + min(l & 3, layout.groupsX - 1);
      out.planes[k].at[0][l] = planes[k * layout.groups + g];
      out.planes[k].at[1][l] = planes[(3 + k) * layout.groups + g];
      highest = max(highest, out.planes[k].at[1][l]); // no effect for an empty group
    }
    out.extent[k] = highest - block->origin[k];
  }

  /*! Sets the planes of groups on axis k to the bounds of their leaves' boxes, and the extent. */
  void setPlanesOfTile(int k, VertBlockEntry& out) const {
    const float origin = block->origin[k], unit = tileBoxUnit(block, k);
    uint32_t highest = 0;
    for (uint32_t lane = 0; lane < 16; lane++) {
      const uint32_t leaf = (lane & 3) + 8 * (lane >> 2);
      uint32_t lower = maxBoxByte, upper = 0;
      for (uint32_t l : {leaf, leaf + 4}) {
        if (!((tileLeaves(block->region) >> l) & 1u)) continue;
        lower = min(lower, tilePlane(block, l, k, 0));
        upper = max(upper, tilePlane(block, l, k, 1));
      }
      // outwards, because planes of a tile with floats are rounded
      out.planes[k].at[0][lane] = std::nextafter(origin + float(lower) * unit, float(neg_inf));
      out.planes[k].at[1][lane] = std::nextafter(origin + float(upper) * unit, float(pos_inf));
      highest = max(highest, upper);
    }
    out.extent[k] = float(highest + 1) * unit;
  }

  void copyVerticesOfTile(uint32_t gx, uint32_t gy, CellVertices& out) const {
    for (uint32_t j = 0; j < 5; j++)
      for (uint32_t i = 0; i < 5; i++)
        for (int k = 0; k < 3; k++)
          out.at[k][laneOfVertex(i, j)] =
              tileVertex(block, min(groupQuads * gx + i, quadsX), min(groupQuads * gy + j, quadsY), k);
  }

  const VertHeader* block;
  const VertLayout layout;
  const uint32_t quadsX, quadsY;
  const VertSpacing spacing;
};
} // namespace embree::isa::cbvh
