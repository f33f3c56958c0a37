// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoder of a block of cVERT, vert/format.h: what its groups have in common, then a group at a time. */

#include "cell_decoder.h"
#include "axes.h"
#include "../embree/ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      class VertDecoder
      {
      public:
        __forceinline VertDecoder (const VertHeader* block)
          : block(block), layout(vertLayout(block->region,block->boxForm)), quadsX(vertQuadsX(block->region)), quadsY(vertQuadsY(block->region)), spacing(vertSpacing(block->word)) {}

        /*! everything that all groups need */
        __forceinline void decode (VertBoxes& out) const
        {
          out.lanes = ((1u << layout.groupsX)-1)*0x1111u & ((1u << 4*layout.groupsY)-1);
          setAxes(block,out);
          if (unlikely(isRaw(block->boxForm))) {
            for (int k=0; k<3; k++) copyPlanes(k,out);
            return;
          }
          CellVertices corners;
          decodeCorners(corners);
          pack(corners,out.corners);
          planes(corners,out);
          cells(out);
        }

        /*! quads of the group in a lane, in the world; boxes: of the block */
        __forceinline void quads (const VertBoxes& boxes, uint32_t lane, QuadCorners& out) const
        {
          const uint32_t gx = lane & 3, gy = lane >> 2;
          if (unlikely(isRaw(block->boxForm))) {
            copy(gx,gy,out);
            return;
          }
          auto corner = [&](int c) { return coordinatesAt(boxes.corners.at[vertTables.corners[lane][c]]); };
          const CellPrediction prediction(corner(0),corner(1),corner(2),corner(3));
          CellDecoder(boxes.words[lane],bytes(boxes.fields[lane]),prediction,true,quadsOfGroup(quadsX,gx),quadsOfGroup(quadsY,gy)).decode(WorldOfCell{ out,spacing,block->origin });
        }

      private:
        /*! corners of groups, in coordinates */
        __forceinline void decodeCorners (CellVertices& out) const
        {
          auto corner = [&](int c) { return coordinatesAt((const uint16_t*)block->corners + 3*c); };
          const CellPrediction prediction(corner(0),corner(1),corner(2),corner(3));
          CellDecoder(block->word,bytes(layout.cell),prediction,false,quadsX,quadsY).decode(CoordinatesOfCell{ out });
        }

        /*! coordinates are less than maxExtent */
        static __forceinline void pack (const CellVertices& v, CellCoordinates& out)
        {
          for (int l=0; l<cellVertices; l+=4)
          {
            auto four = [&](int k) { return _mm_cvttps_epi32(_mm_load_ps(v.at[k]+l)); };
            const __m128i xy = _mm_or_si128(four(0),_mm_slli_epi32(four(1),16)), z = four(2);
            _mm_store_si128((__m128i*)out.at[l],_mm_unpacklo_epi32(xy,z));
            _mm_store_si128((__m128i*)out.at[l+2],_mm_unpackhi_epi32(xy,z));
          }
        }

        __forceinline void planes (const CellVertices& corners, VertBoxes& out) const
        {
          const int m = out.axis;
          for (int k=0; k<3; k++)
            if (k != m) planes(k,corners.at[k],block->origin[k],out);

          const int m1 = axisAfter(m,1), m2 = axisAfter(m,2);
          const vfloatV s1(out.shear[m1]), s2(out.shear[m2]);
          alignas(64) float sheared[VertTables::lanes];
          for (int c=0; c<cellVectors; c++) {
            const int n = vectorWidth*c;
            vfloatV::store(sheared+n,madd(s2,vfloatV::load(corners.at[m2]+n),madd(s1,vfloatV::load(corners.at[m1]+n),vfloatV::load(corners.at[m]+n))));
          }
          planes(m,sheared,0.0f,out);
        }

        __forceinline void planes (int k, const float* vertices, float from, VertBoxes& out) const
        {
          alignas(16) uint8_t expanded[24]; // 8 are read at a time
          const uint8_t* margins = expandRows((const uint8_t*)block + layout.margins + k*layout.groups,expanded);
          const vfloatV spacing(this->spacing), origin(from), step(float(1u << marginShift(block->boxForm,k)));
          const QuadCornersV corners{CellVector(vertices)};
          for (int j=0; j<QuadCornersV::vectors; j++) {
            const vfloatV c[4] = { corners.at(j,0),corners.at(j,1),corners.at(j,2),corners.at(j,3) };
            const vintV m = loadBytes(margins+vectorWidth*j);
            vfloatV::store(out.planes[k].at[0]+vectorWidth*j,madd(nmadd(vfloatV(m & vintV(15)),step,min(min(c[0],c[1]),min(c[2],c[3]))),spacing,origin));
            vfloatV::store(out.planes[k].at[1]+vectorWidth*j,madd(madd(vfloatV(m >> 4),step,max(max(c[0],c[1]),max(c[2],c[3]))),spacing,origin));
          }
        }

        /*! Words of groups, and where their fields are: behind those of the groups before. */
        __forceinline void cells (VertBoxes& out) const
        {
          const uint32_t begin = layout.cell + cellBytes(block->word);
          if (unlikely(layout.groups != maxVertGroups))
          {
            uint32_t at = begin;
            for (uint32_t g=0; g<layout.groups; g++)
            {
              uint16_t low;
              memcpy(&low,bytes(layout.words+2*g),sizeof(low));
              const uint32_t lane = 4*(g/layout.groupsX) + g % layout.groupsX;
              out.words[lane] = uint32_t(low) | uint32_t(*bytes(layout.wordsHigh+g)) << 16;
              out.fields[lane] = uint16_t(at);
              at += cellBytes(low);
            }
            return;
          }
          const __m128i upper = _mm_loadu_si128((const __m128i*)bytes(layout.wordsHigh)), nibble = _mm_set1_epi16(15);
          __m128i before = _mm_set1_epi16(short(begin));
          for (int half=0; half<2; half++)
          {
            const __m128i low = _mm_loadu_si128((const __m128i*)bytes(layout.words+16*half));
            const __m128i high = half ? _mm_unpackhi_epi8(upper,_mm_setzero_si128()) : _mm_unpacklo_epi8(upper,_mm_setzero_si128());
            _mm_store_si128((__m128i*)(out.words+8*half),_mm_unpacklo_epi16(low,high));
            _mm_store_si128((__m128i*)(out.words+8*half+4),_mm_unpackhi_epi16(low,high));
            const __m128i bits = _mm_add_epi16(_mm_and_si128(low,nibble),
              _mm_add_epi16(_mm_and_si128(_mm_srli_epi16(low,4),nibble),_mm_and_si128(_mm_srli_epi16(low,8),nibble)));
            const __m128i size = _mm_srli_epi16(_mm_add_epi16(_mm_mullo_epi16(bits,_mm_set1_epi16(cellFields)),_mm_set1_epi16(7)),3);
            __m128i sum = _mm_add_epi16(size,_mm_slli_si128(size,2));
            sum = _mm_add_epi16(sum,_mm_slli_si128(sum,4));
            sum = _mm_add_epi16(sum,_mm_slli_si128(sum,8));
            _mm_storeu_si128((__m128i*)(out.fields+8*half),_mm_add_epi16(before,_mm_sub_epi16(sum,size)));
            before = _mm_add_epi16(before,_mm_shuffle_epi32(_mm_shufflehi_epi16(sum,_MM_SHUFFLE(3,3,3,3)),_MM_SHUFFLE(3,3,3,3)));
          }
        }

        __forceinline const uint8_t* bytes (uint32_t offset) const { return (const uint8_t*)block + offset; }

        /*! a byte a group to a byte a lane; reads up to 16 bytes, which a block has there */
        __forceinline const uint8_t* expandRows (const uint8_t* rows, uint8_t* out) const
        {
          if (likely(layout.groupsX == 4)) return rows;
          for (int i=0; i<24; i++) out[i] = 0;
          for (uint32_t y=0; y<layout.groupsY; y++)
            for (uint32_t x=0; x<layout.groupsX; x++) out[4*y+x] = rows[y*layout.groupsX+x];
          return out;
        }

        static __forceinline vintV loadBytes (const uint8_t* p)
        {
#if defined(__AVX512F__)
          return vintV(_mm512_cvtepu8_epi32(_mm_loadu_si128((const __m128i*)p)));
#else
          return vintV::load((const unsigned char*)p);
#endif
        }

        void copy (uint32_t gx, uint32_t gy, QuadCorners& out) const
        {
          const float (*v)[3] = (const float (*)[3])bytes(layout.vertices);
          for (uint32_t q=0; q<16; q++)
            for (uint32_t c=0; c<4; c++)
            {
              const uint32_t x = min(groupQuads*gx + (q & 3) + (c & 1),quadsX), y = min(groupQuads*gy + (q >> 2) + (c >> 1),quadsY);
              for (int k=0; k<3; k++) out.at[c][k][q] = v[y*(quadsX+1)+x][k];
            }
        }

        void copyPlanes (int k, VertBoxes& out) const
        {
          const float* planes = (const float*)bytes(layout.boxes);
          float highest = block->origin[k];
          for (uint32_t l=0; l<16; l++) {
            const uint32_t g = min(l >> 2,layout.groupsY-1)*layout.groupsX + min(l & 3,layout.groupsX-1);
            out.planes[k].at[0][l] = planes[k*layout.groups+g];
            out.planes[k].at[1][l] = planes[(3+k)*layout.groups+g];
            highest = max(highest,out.planes[k].at[1][l]); // an empty group has none
          }
          out.extent[k] = highest - block->origin[k];
        }

        const VertHeader* block;
        const VertLayout layout;
        const uint32_t quadsX, quadsY;
        const float spacing;
      };
    }
  }
}
