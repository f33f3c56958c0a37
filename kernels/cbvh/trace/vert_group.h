// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoder of a cell of cVERT, codec/vertex_cell.h, all vertices of an axis at a time. Floats hold
 * every number here exactly, so this equals the codec's integers, fused or not. */

#include "vert_tables.h"
#include "../codec/vert_block.h"
#include "../../common/ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

#if defined(__AVX512F__)
      static const int vertWidth = 16;
#elif defined(__AVX__)
      static const int vertWidth = 8;
#else
      static const int vertWidth = 4;
#endif
      typedef vfloat<vertWidth> vfloatV;
      typedef vint<vertWidth> vintV;
      typedef vboolf<vertWidth> vboolV;

      /*! vectors that have the vertices of a cell */
      static const int cellVectors = (cellVertices+vertWidth-1)/vertWidth;

      /*! corners of a cell, by axis: 00, 10, 01, 11; floats that are integers */
      struct CellCorners { float at[3][4]; };

      /*! vertices of a cell by axis, in a lane each */
      struct alignas(64) CellVertices { float at[3][VertTables::lanes]; };

      /*! fields of a cell, lane by lane; bits above the field's are not cleared */
      struct CellFields
      {
        vintV lanes[cellVectors];

        /*! reads up to 8 bytes behind the last field */
        __forceinline CellFields (const uint8_t* data, int bits)
        {
#if defined(__AVX512F__)
          const int words = (cellFields*bits+31) >> 5; // at most 21
          const __mmask16 low = words < 16 ? __mmask16((1u << words)-1) : __mmask16(0xFFFF);
          const __mmask16 high = words < 16 ? __mmask16(0) : __mmask16((1u << (words-16))-1);
          const __m512i a = _mm512_maskz_loadu_epi32(low,data), b = _mm512_maskz_loadu_epi32(high,data+64);
          for (int c=0; c<cellVectors; c++)
          {
            const __m512i bit = _mm512_mullo_epi32(_mm512_load_si512((const void*)(vertTables.field+16*c)),_mm512_set1_epi32(bits));
            const __m512i word = _mm512_srli_epi32(bit,5), shift = _mm512_and_si512(bit,_mm512_set1_epi32(31));
            const __m512i first = _mm512_permutex2var_epi32(a,word,b);
            const __m512i second = _mm512_permutex2var_epi32(a,_mm512_add_epi32(word,_mm512_set1_epi32(1)),b);
            /* a shift by 32 makes 0 */
            lanes[c] = _mm512_or_si512(_mm512_srlv_epi32(first,shift),_mm512_sllv_epi32(second,_mm512_sub_epi32(_mm512_set1_epi32(32),shift)));
          }
#else
          alignas(64) uint32_t fields[VertTables::lanes];
          fields[0] = fields[4] = fields[20] = fields[24] = 0;
          for (int l=cellVertices; l<VertTables::lanes; l++) fields[l] = 0;
          for (int f=0, bit=0; f<cellFields; f++, bit+=bits) {
            uint64_t word;
            memcpy(&word,data + (bit >> 3),sizeof(word));
            fields[vertTables.laneOfField[f]] = uint32_t(word >> (bit & 7));
          }
          for (int c=0; c<cellVectors; c++) lanes[c] = vintV::load((int*)fields + vertWidth*c);
#endif
        }
      };

      /*! component of residuals before slopes; without any bits a shift by 32 makes 0 */
      __forceinline vfloatV residualOf (const vintV& fields, int shift, int bits) {
        return vfloatV((fields << (bits == 0 ? 32 : 32-bits-shift)) >> (32-bits));
      }

      /*! Decodes a cell to coordinates of the block. ofQuads: a group's, else the first cell's;
       *  quads: along its sides. */
      __forceinline void decodeCell (uint32_t word, const uint8_t* data, const CellCorners& corners, bool ofQuads, uint32_t quadsX, uint32_t quadsY, CellVertices& out)
      {
        const int bits0 = cellBits(word,0), bits1 = cellBits(word,1), bits2 = cellBits(word,2), bits = bits0+bits1+bits2;
        const int axis0 = cellAxis(word,0), axis1 = cellAxis(word,1), axis2 = cellAxis(word,2);
        const float slope1 = float(cellSlope(word,1))*(1.0f/16.0f), slope2 = float(cellSlope(word,2))*(1.0f/16.0f);
        const float* weightX = vertTables.weightX[ofQuads][quadsX-1];
        const float* weightY = vertTables.weightY[ofQuads][quadsY-1];
        const CellFields fields(data,bits);
        for (int c=0; c<cellVectors; c++)
        {
          const vfloatV x = vfloatV::load(weightX+vertWidth*c), y = vfloatV::load(weightY+vertWidth*c), xy = x*y;
          const vintV field = fields.lanes[c] & vintV::load(vertTables.hasField+vertWidth*c);
          const vfloatV half(0.5f);
          auto decode = [&](int axis, const vfloatV& residual) {
            const float* k = corners.at[axis];
            const vfloatV p = madd(vfloatV(k[3]-k[1]-k[2]+k[0]),xy,madd(vfloatV(k[2]-k[0]),y,madd(vfloatV(k[1]-k[0]),x,half)));
            vfloatV::store(out.at[axis]+vertWidth*c,vfloatV(k[0]) + floor(p) + residual);
          };
          const vfloatV main = residualOf(field,0,bits0);
          decode(axis0,main);
          decode(axis1,residualOf(field,bits0,bits1) + floor(madd(vfloatV(slope1),main,half)));
          decode(axis2,residualOf(field,bits0+bits1,bits2) + floor(madd(vfloatV(slope2),main,half)));
        }
      }

      /*! A block that a ray looks into: decodes groups, and before the first of them the block's
       *  own cell. */
      class VertGroups
      {
      public:
        __forceinline VertGroups (const VertHeader* block, const VertLayout& layout)
          : block(block), layout(layout), quadsX(vertQuadsX(block->place)), quadsY(vertQuadsY(block->place)), hasCorners(false) {}

        /*! vertices of a group in the world */
        __forceinline void decode (uint32_t g, CellVertices& out)
        {
          const uint32_t gx = layout.groupsX == 4 ? g & 3 : g % layout.groupsX, gy = layout.groupsX == 4 ? g >> 2 : g / layout.groupsX;
          if (unlikely(isRaw(block->boxShifts))) { copy(gx,gy,out); return; }
          const uint32_t* words = (const uint32_t*)((const char*)block + layout.words);
          if (!hasCorners) decodeCorners();
          CellCorners corners;
          for (int k=0; k<3; k++)
            for (uint32_t c=0; c<4; c++)
              corners.at[k][c] = first.at[k][5*(gy+(c >> 1)) + gx+(c & 1)];
          decodeCell(words[g],groupData(words,g),corners,true,quadsOfGroup(quadsX,gx),quadsOfGroup(quadsY,gy),out);
          for (int k=0; k<3; k++)
            for (int c=0; c<cellVectors; c++) {
              float* p = out.at[k]+vertWidth*c;
              vfloatV::store(p,madd(vfloatV::load(p),vfloatV(block->spacing),vfloatV(block->origin[k])));
            }
        }

      private:
        __forceinline void decodeCorners ()
        {
          hasCorners = true;
          CellCorners corners;
          for (int k=0; k<3; k++)
            for (int c=0; c<4; c++)
              corners.at[k][c] = float(cornerCoordinate(block->corners[cornerPair(c,k)],c,k));
          decodeCell(block->word,(const uint8_t*)block + layout.cell,corners,false,quadsX,quadsY,first);
        }

        /*! fields of a group come behind those of the groups before it */
        __forceinline const uint8_t* groupData (const uint32_t* words, uint32_t g) const
        {
          uint32_t offset = layout.cell + cellBytes(block->word);
#if defined(__AVX512F__)
          const __m512i w = _mm512_maskz_loadu_epi32(__mmask16((1u << g)-1),words);
          offset += uint32_t(_mm512_reduce_add_epi32(_mm512_srli_epi32(w,24)));
#else
          for (uint32_t i=0; i<g; i++) offset += cellBytes(words[i]);
#endif
          return (const uint8_t*)block + offset;
        }

        void copy (uint32_t gx, uint32_t gy, CellVertices& out) const
        {
          const float (*v)[3] = (const float (*)[3])((const char*)block + layout.words);
          for (uint32_t n=0; n<uint32_t(VertTables::lanes); n++)
          {
            const uint32_t l = n < uint32_t(cellVertices) ? n : 0;
            const uint32_t x = min(groupQuads*gx + l % 5,quadsX), y = min(groupQuads*gy + l / 5,quadsY);
            for (int k=0; k<3; k++) out.at[k][n] = v[y*(quadsX+1)+x][k];
          }
        }

        const VertHeader* block;
        const VertLayout& layout;
        uint32_t quadsX, quadsY;
        bool hasCorners;
        CellVertices first;   //!< corners of groups
      };
    }
  }
}
