// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Blocks of cVERT in scalar code, straight from the codec: what the SIMD code has to equal. For tests, to read, and where a whole
 * block is wanted and nothing else. */

#include "format.h"
#include <cstring>

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    class ScalarVertBlock
    {
    public:
      static const uint32_t maxSide = (1u << maxVertHeight) + 1u;

      float vertices[maxSide*maxSide][3]; //!< in the world, row by row
      uint32_t quadsX, quadsY;

      explicit ScalarVertBlock(const VertHeader* block) : quadsX(vertQuadsX(block->region)), quadsY(vertQuadsY(block->region)), block(block), layout(vertLayout(block->region,block->boxForm))
      {
        if (isRaw(block->boxForm)) { memcpy(vertices,bytes(layout.vertices),sizeof(vertices[0])*(quadsX+1)*(quadsY+1)); return; }
        int corners[3][4];
        for (int k=0; k<3; k++)
          for (int c=0; c<4; c++)
            corners[k][c] = cornerCoordinate(block->corners[cornerPair(c,k)],c,k);
        decodeCell(block->word,bytes(layout.cell),corners,int(groupQuads),quadsX,quadsY,first);
        const uint8_t* data = bytes(layout.cell) + cellBytes(block->word);
        for (uint32_t g=0; g<layout.groups; g++)
        {
          const uint32_t gx = g % layout.groupsX, gy = g / layout.groupsX;
          for (int k=0; k<3; k++)
            for (uint32_t c=0; c<4; c++)
              corners[k][c] = first[k][5*(gy+(c >> 1)) + gx+(c & 1)];
          const uint32_t word = wordOf(g);
          int group[3][cellVertices];
          decodeCell(word,data,corners,1,quadsOfGroup(quadsX,gx),quadsOfGroup(quadsY,gy),group);
          data += cellBytes(word);
          for (uint32_t j=0; j<=quadsOfGroup(quadsY,gy); j++)
            for (uint32_t i=0; i<=quadsOfGroup(quadsX,gx); i++)
              for (int k=0; k<3; k++)
                vertices[(groupQuads*gy+j)*(quadsX+1) + groupQuads*gx+i][k] = block->origin[k] + float(group[k][5*j+i])*vertSpacing(block->word);
        }
        end = data;
      }

      /*! Box of a group in the world: lower, upper; on the sheared axis between sheared coordinates times
       *  the spacing, without the origin. */
      void groupBox(uint32_t g, float lower[3], float upper[3]) const
      {
        const uint32_t gx = g % layout.groupsX, gy = g / layout.groupsX;
        for (int k=0; k<3; k++)
        {
          if (isRaw(block->boxForm)) {
            memcpy(lower+k,bytes(layout.boxes) + 4*(k*layout.groups+g),sizeof(float));
            memcpy(upper+k,bytes(layout.boxes) + 4*((3+k)*layout.groups+g),sizeof(float));
            continue;
          }
          const uint32_t margins = bytes(layout.margins)[k*layout.groups+g], shift = marginShift(block->boxForm,k);
          const bool isSheared = k == shearedAxis(block->boxForm);
          int lo = 0, hi = 0; // in 1/16
          for (uint32_t c=0; c<4; c++) {
            const uint32_t corner = 5*(gy+(c >> 1)) + gx+(c & 1);
            const int v = isSheared ? sheared(corner) : 16*first[k][corner];
            lo = c == 0 || v < lo ? v : lo;
            hi = c == 0 || v > hi ? v : hi;
          }
          const float origin = isSheared ? 0.0f : block->origin[k];
          lower[k] = origin + float(lo-16*lowerMargin(margins,shift))*(1.0f/16.0f)*vertSpacing(block->word);
          upper[k] = origin + float(hi+16*upperMargin(margins,shift))*(1.0f/16.0f)*vertSpacing(block->word);
        }
      }

      const float* vertex(uint32_t x, uint32_t y) const { return vertices[y*(quadsX+1)+x]; }

      const uint8_t* end = nullptr; //!< of a block that is not raw

    private:
      const uint8_t* bytes(uint32_t offset) const { return (const uint8_t*)block + offset; }

      /*! of a corner of groups, in 1/16 */
      int sheared(uint32_t corner) const
      {
        const int m = shearedAxis(block->boxForm);
        return 16*first[m][corner] + shearSlope(block->boxForm,1)*first[(m+1)%3][corner] + shearSlope(block->boxForm,2)*first[(m+2)%3][corner];
      }

      uint32_t wordOf(uint32_t g) const
      {
        uint16_t low;
        memcpy(&low,bytes(layout.words + 2*g),sizeof(low));
        return uint32_t(low) | uint32_t(*bytes(layout.wordsHigh + g)) << 16;
      }

      /*! corners, out: by axis */
      static void decodeCell(uint32_t word, const uint8_t* data, const int corners[3][4], int step, uint32_t quadsX, uint32_t quadsY, int out[3][cellVertices])
      {
        const int bits[3] = { cellBits(word,0),cellBits(word,1),cellBits(word,2) }, sum = cellFieldBits(word);
        for (int j=0; j<5; j++)
          for (int i=0; i<5; i++)
          {
            int residual[3] = { 0,0,0 };
            const int f = cellField(i,j);
            if (f >= 0) {
              for (int c=0, before=0; c<3; before+=bits[c++]) {
                const int begin = isByAxis(word) ? cellFields*before + f*bits[c] : f*sum + before;
                uint32_t field = 0;
                for (int b=0; b<bits[c]; b++) field |= uint32_t((data[(begin+b) >> 3] >> ((begin+b) & 7)) & 1) << b;
                residual[c] = cellResidual(field,0,bits[c]) + (c == 0 ? 0 : slopeResidual(cellSlope(word,c),residual[0]));
              }
            }
            for (int c=0; c<3; c++) {
              const int axis = cellAxis(word,c);
              const int* k = corners[axis];
              out[axis][5*j+i] = cellPrediction(k[0],k[1],k[2],k[3],cellWeight(i,step,int(quadsX)),cellWeight(j,step,int(quadsY))) + residual[c];
            }
          }
      }

      const VertHeader* block;
      VertLayout layout;
      int first[3][cellVertices];         //!< corners of groups
    };
  }}
}
