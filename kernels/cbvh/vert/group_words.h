// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Words of the groups of a block of cVERT, and where their fields are: behind those of the groups before. */

#include "../base/codec.h"
#include "../../cvert/format/block.h"
#include "../embree/simd.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

      /*! low, high: halves of words, by group; high may be null. begin: where the fields of the first group are. words, fields: by lane.
       *  Reads up to 16 bytes at `high`, which a block has there. */
      __forceinline void decodeGroupWords (const uint8_t* low, const uint8_t* high, uint32_t begin, const VertLayout& layout, uint32_t words[16], uint16_t fields[16])
      {
        if (unlikely(layout.groups != maxVertGroups))
        {
          uint32_t at = begin;
          for (uint32_t g=0; g<layout.groups; g++)
          {
            uint16_t lower;
            memcpy(&lower,low+2*g,sizeof(lower));
            const uint32_t lane = 4*(g/layout.groupsX) + g % layout.groupsX;
            words[lane] = uint32_t(lower) | (high ? uint32_t(high[g]) << 16 : 0u);
            fields[lane] = uint16_t(at);
            at += cellBytes(lower);
          }
          return;
        }
        const __m128i upper = high ? _mm_loadu_si128((const __m128i*)high) : _mm_setzero_si128(), nibble = _mm_set1_epi16(15);
        __m128i before = _mm_set1_epi16(short(begin));
        for (int half=0; half<2; half++)
        {
          const __m128i lower = _mm_loadu_si128((const __m128i*)(low+16*half));
          const __m128i higher = half ? _mm_unpackhi_epi8(upper,_mm_setzero_si128()) : _mm_unpacklo_epi8(upper,_mm_setzero_si128());
          _mm_store_si128((__m128i*)(words+8*half),_mm_unpacklo_epi16(lower,higher));
          _mm_store_si128((__m128i*)(words+8*half+4),_mm_unpackhi_epi16(lower,higher));
          const __m128i bits = _mm_add_epi16(_mm_and_si128(lower,nibble),
            _mm_add_epi16(_mm_and_si128(_mm_srli_epi16(lower,4),nibble),_mm_and_si128(_mm_srli_epi16(lower,8),nibble)));
          const __m128i size = _mm_srli_epi16(_mm_add_epi16(_mm_mullo_epi16(bits,_mm_set1_epi16(cellFields)),_mm_set1_epi16(7)),3);
          __m128i sum = _mm_add_epi16(size,_mm_slli_si128(size,2));
          sum = _mm_add_epi16(sum,_mm_slli_si128(sum,4));
          sum = _mm_add_epi16(sum,_mm_slli_si128(sum,8));
          _mm_storeu_si128((__m128i*)(fields+8*half),_mm_add_epi16(before,_mm_sub_epi16(sum,size)));
          before = _mm_add_epi16(before,_mm_shuffle_epi32(_mm_shufflehi_epi16(sum,_MM_SHUFFLE(3,3,3,3)),_MM_SHUFFLE(3,3,3,3)));
        }
      }
    }
  }
}
