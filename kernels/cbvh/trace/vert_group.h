// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoder of a cell of cVERT, codec/vertex_cell.h, all vertices of an axis at a time. Floats hold
 * every number here exactly, so this equals the codec's integers, fused or not. */

#include "vert_cache.h"
#include "wide_vector.h"
#include "../codec/vert_block.h"
#include "../../common/ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

      /*! Vectors that have the vertices of a cell, and those of them that have fields: the last vertex, which
       *  is a corner, may have one of its own. */
      static const int cellVectors = (cellVertices+vectorWidth-1)/vectorWidth;
      static const int fieldVectors = (cellVertices-1+vectorWidth-1)/vectorWidth;

      /*! Corners of a cell, floats that are integers: 00, 10, 01, 11, each of three axes. The first
       *  is at a, the others are right, up, and both apart. */
      struct CellCorners
      {
        const float* a[3];  //!< by axis
        int right, up;

        __forceinline vfloatV at (int axis, int corner) const {
          return vfloatV(a[axis][(corner & 1 ? right : 0) + (corner & 2 ? up : 0)]);
        }
      };

      /*! fields of a cell, lane by lane, 0 in lanes without one; bits above the field's are not cleared */
      struct CellFields
      {
        vintV lanes[fieldVectors];

        /*! start: of the first, in bits; reads up to 8 bytes behind the last field */
        __forceinline CellFields (const uint8_t* data, int bits, int start = 0)
        {
#if defined(__AVX512F__)
          const int words = (start+cellFields*bits+31) >> 5; // at most 30
          const __mmask16 low = words < 16 ? __mmask16((1u << words)-1) : __mmask16(0xFFFF);
          const __mmask16 high = words < 16 ? __mmask16(0) : __mmask16((1u << (words-16))-1);
          const __m512i a = _mm512_maskz_loadu_epi32(low,data), b = _mm512_maskz_loadu_epi32(high,data+64);
          for (int c=0; c<fieldVectors; c++)
          {
            const __m512i bit = _mm512_add_epi32(_mm512_mullo_epi32(_mm512_load_si512((const void*)(vertTables.field+16*c)),_mm512_set1_epi32(bits)),_mm512_set1_epi32(start));
            const __m512i word = _mm512_srli_epi32(bit,5), shift = _mm512_and_si512(bit,_mm512_set1_epi32(31));
            const __m512i first = _mm512_permutex2var_epi32(a,word,b);
            const __m512i second = _mm512_permutex2var_epi32(a,_mm512_add_epi32(word,_mm512_set1_epi32(1)),b);
            /* a shift by 32 makes 0 */
            lanes[c] = _mm512_or_si512(_mm512_srlv_epi32(first,shift),_mm512_sllv_epi32(second,_mm512_sub_epi32(_mm512_set1_epi32(32),shift)));
            lanes[c] = lanes[c] & vintV::load(vertTables.hasField+16*c);
          }
#else
#if defined(__SSE4_1__)
          if (likely(start == 0 && VertTables::hasWindows(bits))) {
            const VertTables::Windows& windows = vertTables.windows[bits];
            if (likely(bits <= VertTables::maxBitsOfFour)) {
              for (int c=0; c<fieldVectors; c++) lanes[c] = inFourBytes(data,windows,c);
              return;
            }
#if defined(__AVX2__)
            for (int c=0; c<fieldVectors; c++) lanes[c] = inFiveBytes(data,windows,c);
            return;
#endif
          }
#endif
          alignas(64) uint32_t fields[VertTables::lanes];
          fields[0] = fields[4] = fields[20] = fields[24] = 0;
          for (int l=cellVertices; l<VertTables::lanes; l++) fields[l] = 0;
          for (int f=0, bit=start; f<cellFields; f++, bit+=bits) {
            uint64_t word;
            memcpy(&word,data + (bit >> 3),sizeof(word));
            fields[vertTables.laneOfField[f]] = uint32_t(word >> (bit & 7));
          }
          for (int c=0; c<fieldVectors; c++) lanes[c] = vintV::load((int*)fields + vectorWidth*c);
#endif
        }

      private:
#if defined(__SSE4_1__) && !defined(__AVX512F__)
        static __forceinline __m128i pick (const uint8_t* data, const VertTables::Windows& windows, int i, const uint8_t (*control)[16]) {
          return _mm_shuffle_epi8(_mm_loadu_si128((const __m128i*)(data + windows.offset[i])),_mm_load_si128((const __m128i*)control[i]));
        }

        /*! fields of four lanes */
        static __forceinline vint4 ofWindow (const uint8_t* data, const VertTables::Windows& windows, int i) {
          return _mm_srli_epi32(_mm_mullo_epi32(pick(data,windows,i,windows.control),_mm_load_si128((const __m128i*)(windows.factor+4*i))),7);
        }

#if defined(__AVX__)
        static __forceinline vint8 inFourBytes (const uint8_t* data, const VertTables::Windows& windows, int c) {
          return vint8(ofWindow(data,windows,2*c),ofWindow(data,windows,2*c+1));
        }
#else
        static __forceinline vint4 inFourBytes (const uint8_t* data, const VertTables::Windows& windows, int c) { return ofWindow(data,windows,c); }
#endif

#if defined(__AVX2__)
        static __forceinline vint8 inFiveBytes (const uint8_t* data, const VertTables::Windows& windows, int c)
        {
          const vint8 low(vint4(pick(data,windows,2*c,windows.control)),vint4(pick(data,windows,2*c+1,windows.control)));
          const vint8 fifth(vint4(pick(data,windows,2*c,windows.fifth)),vint4(pick(data,windows,2*c+1,windows.fifth)));
          const __m256i shift = _mm256_load_si256((const __m256i*)(windows.shift+8*c));
          /* a shift by 32 makes 0 */
          return _mm256_or_si256(_mm256_srlv_epi32(low,shift),_mm256_sllv_epi32(fifth,_mm256_sub_epi32(_mm256_set1_epi32(32),shift)));
        }
#endif
#endif
      };

      /*! component of residuals before slopes; without any bits a shift by 32 makes 0 */
      __forceinline vfloatV residualOf (const vintV& fields, int shift, int bits) {
        return vfloatV((fields << (bits == 0 ? 32 : 32-bits-shift)) >> (32-bits));
      }

      /*! predictions of one coordinate of a cell's vertices */
      struct CellPrediction
      {
        vfloatV k, dx, dy, dxy;

        __forceinline CellPrediction (const CellCorners& corners, int axis)
        {
          k = corners.at(axis,0);
          dx = corners.at(axis,1) - k;
          dy = corners.at(axis,2) - k;
          dxy = corners.at(axis,3) - k - dx - dy;
        }

        __forceinline vfloatV at (const vfloatV& x, const vfloatV& y, const vfloatV& xy) const {
          return k + floor(madd(dxy,xy,madd(dy,y,madd(dx,x,vfloatV(0.5f)))));
        }
      };

      /*! where vertices go: coordinates of the block as they are, or points of the world */
      struct CoordinatesOfCell
      {
        CellVertices& out;
        __forceinline void put (int axis, int n, const vfloatV& x) const { vfloatV::store(out.at[axis]+n,x); }
      };

      struct WorldOfCell
      {
        CellVertices& out;
        const float spacing;
        const float* origin;
        __forceinline void put (int axis, int n, const vfloatV& x) const { vfloatV::store(out.at[axis]+n,madd(x,vfloatV(spacing),vfloatV(origin[axis]))); }
      };

      /*! puts the last vertex, where no vector with fields has it */
      template<typename Out>
      __forceinline void putLast (const CellCorners& corners, const Out& out)
      {
        if (fieldVectors == cellVectors) return;
        for (int axis=0; axis<3; axis++) out.put(axis,vectorWidth*fieldVectors,corners.at(axis,3));
      }

      /*! Decodes a cell whose residuals come axis by axis: those of rough blocks on fine lattices. */
      template<typename Out>
      inline void decodeByAxis (uint32_t word, const uint8_t* data, const CellCorners& corners, const float* weightX, const float* weightY, const Out& out)
      {
        vfloatV main[fieldVectors];
        for (int i=0, start=0; i<3; start+=cellFields*cellBits(word,i++))
        {
          const int bits = cellBits(word,i), axis = cellAxis(word,i);
          const float slope = i == 0 ? 0.0f : float(cellSlope(word,i))*(1.0f/16.0f);
          const CellFields fields(data,bits,start);
          const CellPrediction prediction(corners,axis);
          for (int c=0; c<fieldVectors; c++)
          {
            const vfloatV x = vfloatV::load(weightX+vectorWidth*c), y = vfloatV::load(weightY+vectorWidth*c);
            vfloatV residual = residualOf(fields.lanes[c],0,bits);
            if (i == 0) main[c] = residual;
            else residual = residual + floor(madd(vfloatV(slope),main[c],vfloatV(0.5f)));
            out.put(axis,vectorWidth*c,prediction.at(x,y,x*y) + residual);
          }
        }
        putLast(corners,out);
      }

      /*! Decodes a cell. ofQuads: a group's, else the first cell's; quads: along its sides. */
      template<typename Out>
      __forceinline void decodeCell (uint32_t word, const uint8_t* data, const CellCorners& corners, bool ofQuads, uint32_t quadsX, uint32_t quadsY, const Out& out)
      {
        const float* weightX = vertTables.weightX[ofQuads][quadsX-1];
        const float* weightY = vertTables.weightY[ofQuads][quadsY-1];
        if (unlikely(isByAxis(word))) {
          decodeByAxis(word,data,corners,weightX,weightY,out);
          return;
        }
        const CellFields fields(data,cellFieldBits(word));
        vfloatV x[fieldVectors], y[fieldVectors], xy[fieldVectors], main[fieldVectors];
        for (int c=0; c<fieldVectors; c++) {
          x[c] = vfloatV::load(weightX+vectorWidth*c);
          y[c] = vfloatV::load(weightY+vectorWidth*c);
          xy[c] = x[c]*y[c];
        }
        for (int i=0, shift=0; i<3; shift+=cellBits(word,i++))
        {
          const int bits = cellBits(word,i), axis = cellAxis(word,i);
          const vfloatV slope(i == 0 ? 0.0f : float(cellSlope(word,i))*(1.0f/16.0f));
          const CellPrediction prediction(corners,axis);
          for (int c=0; c<fieldVectors; c++)
          {
            vfloatV residual = residualOf(fields.lanes[c],shift,bits);
            if (i == 0) main[c] = residual;
            else residual = residual + floor(madd(slope,main[c],vfloatV(0.5f)));
            out.put(axis,vectorWidth*c,prediction.at(x[c],y[c],xy[c]) + residual);
          }
        }
        putLast(corners,out);
      }

      /*! four corners of 4 x 4 cells of vertices, in vectors of cells */
      struct CellCornersV
      {
        static const int vectors = 16/vectorWidth;
        vfloatV at[vectors][4];    //!< 00, 10, 01, 11

        __forceinline CellCornersV (const float* p)
        {
          static const int offsets[4] = { 0,1,5,6 };
#if defined(__AVX512F__)
          const __m512i base = _mm512_setr_epi32(0,1,2,3, 5,6,7,8, 10,11,12,13, 15,16,17,18);
          const __m512 a = _mm512_load_ps(p), b = _mm512_load_ps(p+16);
          for (int c=0; c<4; c++)
            at[0][c] = _mm512_permutex2var_ps(a,_mm512_add_epi32(base,_mm512_set1_epi32(offsets[c])),b);
#elif defined(__AVX__)
          for (int j=0; j<vectors; j++)
            for (int c=0; c<4; c++)
              at[j][c] = vfloat8(vfloat4::loadu(p+10*j+offsets[c]),vfloat4::loadu(p+10*j+5+offsets[c]));
#else
          for (int j=0; j<vectors; j++)
            for (int c=0; c<4; c++)
              at[j][c] = vfloat4::loadu(p+5*j+offsets[c]);
#endif
        }

        /*! to corner, vector and quad */
        __forceinline void store (QuadCorners& out, int axis) const {
          for (int c=0; c<4; c++)
            for (int j=0; j<vectors; j++) vfloatV::store(out.at[c][axis]+vectorWidth*j,at[j][c]);
        }

        __forceinline vfloatV lower (int j) const { return min(min(at[j][0],at[j][1]),min(at[j][2],at[j][3])); }
        __forceinline vfloatV upper (int j) const { return max(max(at[j][0],at[j][1]),max(at[j][2],at[j][3])); }
      };

      /*! Decoder of a block. */
      class VertDecoder
      {
      public:
        __forceinline VertDecoder (const VertHeader* block)
          : block(block), layout(vertLayout(block->place)), quadsX(vertQuadsX(block->place)), quadsY(vertQuadsY(block->place)),
            spacing(vertSpacing(block->word)), extent(float(maxExtent)*spacing) {}

        /*! corners of groups, in coordinates, of a block that is not raw */
        __forceinline void corners (CellVertices& out) const
        {
          alignas(16) float at[4][3];
#if defined(__SSE4_1__)
          for (int i=0; i<3; i++)
            vfloat4::store(&at[0][0]+4*i,vfloat4(vint4(_mm_cvtepu16_epi32(_mm_loadl_epi64((const __m128i*)(block->corners+2*i))))));
#else
          for (int c=0; c<4; c++)
            for (int k=0; k<3; k++)
              at[c][k] = float(cornerCoordinate(block->corners[cornerPair(c,k)],c,k));
#endif
          const CellCorners corners = { { &at[0][0],&at[0][1],&at[0][2] },3,6 };
          decodeCell(block->word,bytes(layout.cell),corners,false,quadsX,quadsY,CoordinatesOfCell{ out });
        }

        /*! planes of boxes; corners: as above */
        __forceinline void planes (const CellVertices& corners, GroupPlanes (&out)[3]) const
        {
          if (unlikely(isRaw(block->boxForm))) {
            for (int k=0; k<3; k++) copyPlanes(k,out[k]);
            return;
          }
          const int m = shearedAxis(block->boxForm);
          for (int k=0; k<3; k++)
            if (k != m) planes(k,CellCornersV(corners.at[k]),block->origin[k],out[k]);

          const vfloatV s1(float(shearSlope(block->boxForm,1))*(1.0f/16.0f)), s2(float(shearSlope(block->boxForm,2))*(1.0f/16.0f));
          alignas(64) float sheared[VertTables::lanes];
          for (int c=0; c<cellVectors; c++) {
            const int n = vectorWidth*c;
            vfloatV::store(sheared+n,madd(s2,vfloatV::load(corners.at[(m+2)%3]+n),madd(s1,vfloatV::load(corners.at[(m+1)%3]+n),vfloatV::load(corners.at[m]+n))));
          }
          planes(m,CellCornersV(sheared),0.0f,out[m]);
        }

      private:
        __forceinline void planes (int k, const CellCornersV& corners, float from, GroupPlanes& out) const
        {
          alignas(16) uint8_t expanded[24]; // 8 are read at a time
          const uint8_t* margins = expandRows((const uint8_t*)block + layout.margins + k*layout.groups,expanded);
          const vfloatV spacing(this->spacing), origin(from), step(float(1u << marginShift(block->boxForm,k)));
          out.extent = extent;
          for (int j=0; j<CellCornersV::vectors; j++) {
            const vintV m = loadBytes(margins+vectorWidth*j);
            vfloatV::store(out.lower+vectorWidth*j,madd(nmadd(vfloatV(m & vintV(15)),step,corners.lower(j)),spacing,origin));
            vfloatV::store(out.upper+vectorWidth*j,madd(madd(vfloatV(m >> 4),step,corners.upper(j)),spacing,origin));
          }
        }

      public:
        /*! quads of the group in a lane, in the world; first: corners, as above */
        __forceinline void quads (const CellVertices& first, uint32_t lane, QuadCorners& out) const
        {
          const uint32_t gx = lane & 3, gy = lane >> 2, g = gy*layout.groupsX + gx;
          CellVertices vertices;
          if (unlikely(isRaw(block->boxForm))) copy(gx,gy,vertices);
          else {
            const uint32_t v = 5*gy + gx;
            const CellCorners corners = { { first.at[0]+v,first.at[1]+v,first.at[2]+v },1,5 };
            decodeCell(wordOf(g),groupData(g),corners,true,quadsOfGroup(quadsX,gx),quadsOfGroup(quadsY,gy),WorldOfCell{ vertices,spacing,block->origin });
          }
          for (int k=0; k<3; k++) CellCornersV(vertices.at[k]).store(out,k);
        }

      private:
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

        __forceinline uint32_t wordOf (uint32_t g) const
        {
          uint16_t low;
          memcpy(&low,bytes(layout.words+2*g),sizeof(low));
          return uint32_t(low) | uint32_t(*bytes(layout.wordsHigh+g)) << 16;
        }

        /*! fields of a group come behind those of the groups before it */
        __forceinline const uint8_t* groupData (uint32_t g) const
        {
          uint32_t offset = layout.cell + cellBytes(block->word);
#if defined(__AVX512F__)
          const __m256i w = _mm256_maskz_loadu_epi16(__mmask16((1u << g)-1),bytes(layout.words));
          const __m256i nibble = _mm256_set1_epi16(15);
          const __m256i bits = _mm256_add_epi16(_mm256_and_si256(w,nibble),
            _mm256_add_epi16(_mm256_and_si256(_mm256_srli_epi16(w,4),nibble),_mm256_and_si256(_mm256_srli_epi16(w,8),nibble)));
          const __m256i size = _mm256_srli_epi16(_mm256_add_epi16(_mm256_mullo_epi16(bits,_mm256_set1_epi16(cellFields)),_mm256_set1_epi16(7)),3);
          const __m256i pairs = _mm256_madd_epi16(size,_mm256_set1_epi16(1));
          offset += uint32_t(reduce_add(vint8(pairs)));
#else
          if (likely(layout.groups == maxVertGroups))
          {
            __m128i size = _mm_setzero_si128();
            for (int half=0; half<2; half++) {
              const __m128i w = _mm_loadu_si128((const __m128i*)bytes(layout.words+16*half)), nibble = _mm_set1_epi16(15);
              const __m128i bits = _mm_add_epi16(_mm_and_si128(w,nibble),
                _mm_add_epi16(_mm_and_si128(_mm_srli_epi16(w,4),nibble),_mm_and_si128(_mm_srli_epi16(w,8),nibble)));
              const __m128i of = _mm_srli_epi16(_mm_add_epi16(_mm_mullo_epi16(bits,_mm_set1_epi16(cellFields)),_mm_set1_epi16(7)),3);
              const __m128i lane = _mm_add_epi16(_mm_setr_epi16(0,1,2,3,4,5,6,7),_mm_set1_epi16(short(8*half)));
              size = _mm_add_epi16(size,_mm_and_si128(of,_mm_cmpgt_epi16(_mm_set1_epi16(short(g)),lane)));
            }
            offset += uint32_t(reduce_add(vint4(_mm_madd_epi16(size,_mm_set1_epi16(1)))));
          }
          else for (uint32_t i=0; i<g; i++) {
            uint16_t low;
            memcpy(&low,bytes(layout.words+2*i),sizeof(low));
            offset += cellBytes(low);
          }
#endif
          return bytes(offset);
        }

        void copy (uint32_t gx, uint32_t gy, CellVertices& out) const
        {
          const float (*v)[3] = (const float (*)[3])bytes(layout.vertices);
          for (uint32_t n=0; n<uint32_t(VertTables::lanes); n++)
          {
            const uint32_t l = n < uint32_t(cellVertices) ? n : 0;
            const uint32_t x = min(groupQuads*gx + l % 5,quadsX), y = min(groupQuads*gy + l / 5,quadsY);
            for (int k=0; k<3; k++) out.at[k][n] = v[y*(quadsX+1)+x][k];
          }
        }

        void copyPlanes (int k, GroupPlanes& out) const
        {
          const float* planes = (const float*)bytes(layout.boxes);
          float highest = block->origin[k];
          for (uint32_t l=0; l<16; l++) {
            const uint32_t g = min(l >> 2,layout.groupsY-1)*layout.groupsX + min(l & 3,layout.groupsX-1);
            out.lower[l] = planes[k*layout.groups+g];
            out.upper[l] = planes[(3+k)*layout.groups+g];
            highest = max(highest,out.upper[l]); // an empty group has none
          }
          out.extent = highest - block->origin[k];
        }

        const VertHeader* block;
        const VertLayout layout;
        const uint32_t quadsX, quadsY;
        const float spacing;
        const float extent;   //!< of the block from its origin, at least; not of a raw one
      };
    }
  }
}
