// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Blocks of cVERT in scalar code, straight from the codec: what the SIMD code has to equal. For tests, to read, and where a whole
 * block is wanted and nothing else. */

#include "motion_format.h"

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

      /*! step: of a block that moves */
      explicit ScalarVertBlock(const VertHeader* block, uint32_t step = 0)
        : quadsX(vertQuadsX(block->region)), quadsY(vertQuadsY(block->region)), block(block), layout(vertLayout(block->region,block->boxForm)), cells(cellsOf(block,step))
      {
        if (cells.isRaw) { memcpy(vertices,cells.data,sizeof(vertices[0])*(quadsX+1)*(quadsY+1)); return; }
        int corners[3][4];
        for (int k=0; k<3; k++)
          for (int c=0; c<4; c++)
            corners[k][c] = cornerCoordinate(cells.corners[cornerPair(c,k)],c,k);
        const VertSpacing spacing = cells.spacing();
        const Cells zero = cellsOf(block,0);
        const uint8_t* data = cells.data, *dataOfZero = zero.data;
        decodeCell(cells.isTurned(-1) ? &zero : nullptr,-1,data,dataOfZero,corners,groupQuads,quadsX,quadsY,first);
        for (uint32_t g=0; g<layout.groups; g++)
        {
          const uint32_t gx = g % layout.groupsX, gy = g / layout.groupsX;
          for (int k=0; k<3; k++)
            for (uint32_t c=0; c<4; c++)
              corners[k][c] = first[k][5*(gy+(c >> 1)) + gx+(c & 1)];
          int group[3][cellVertices];
          decodeCell(cells.isTurned(int(g)) ? &zero : nullptr,int(g),data,dataOfZero,corners,1,quadsOfGroup(quadsX,gx),quadsOfGroup(quadsY,gy),group);
          for (uint32_t j=0; j<=quadsOfGroup(quadsY,gy); j++)
            for (uint32_t i=0; i<=quadsOfGroup(quadsX,gx); i++)
              for (int k=0; k<3; k++)
                vertices[(groupQuads*gy+j)*(quadsX+1) + groupQuads*gx+i][k] = cells.origin[k] + float(group[k][5*j+i])*spacing.at[k];
        }
        end = data;
        if (!cells.remainders) return;
        addRemainders(spacing);
        end = (const uint8_t*)cells.start + remainderOffset(cells.remainders) + bytesOfRemainders(cells.remainders,block->region);
      }

      /*! Box of a group in the world: lower, upper; on the sheared axis between sheared coordinates times
       *  the spacing, without the origin. form, margins: of the segment that begins or ends with this step; by default those of the block */
      void groupBox(uint32_t g, float lower[3], float upper[3]) const { groupBox(g,block->boxForm,bytes(layout.margins),lower,upper); }
      void groupBox(uint32_t g, uint32_t form, const uint8_t* margins, float lower[3], float upper[3]) const
      {
        const uint32_t gx = g % layout.groupsX, gy = g / layout.groupsX;
        for (int k=0; k<3; k++)
        {
          if (cells.isRaw) {
            memcpy(lower+k,bytes(layout.boxes) + 4*(k*layout.groups+g),sizeof(float));
            memcpy(upper+k,bytes(layout.boxes) + 4*((3+k)*layout.groups+g),sizeof(float));
            continue;
          }
          const uint32_t ofAxis = margins[k*layout.groups+g], shift = marginShift(form,k);
          const bool isSheared = k == shearedAxis(form);
          const VertSpacing spacing = cells.spacing();
          float lo = 0, hi = 0;
          for (uint32_t c=0; c<4; c++) {
            const uint32_t corner = 5*(gy+(c >> 1)) + gx+(c & 1);
            const float v = isSheared ? sheared(form,corner) : float(first[k][corner]);
            lo = c == 0 || v < lo ? v : lo;
            hi = c == 0 || v > hi ? v : hi;
          }
          const float origin = isSheared ? 0.0f : cells.origin[k];
          lower[k] = origin + (lo-float(lowerMargin(ofAxis,shift)))*spacing.at[k];
          upper[k] = origin + (hi+float(upperMargin(ofAxis,shift)))*spacing.at[k];
        }
      }

      const float* vertex(uint32_t x, uint32_t y) const { return vertices[y*(quadsX+1)+x]; }

      /*! of the finite ones; false if there is none */
      bool bounds(float lower[3], float upper[3]) const
      {
        for (int k=0; k<3; k++) { lower[k] = INFINITY; upper[k] = -INFINITY; }
        for (uint32_t i=0; i<(quadsX+1)*(quadsY+1); i++)
        {
          const float* p = vertices[i];
          if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))) continue;
          for (int k=0; k<3; k++) { lower[k] = p[k] < lower[k] ? p[k] : lower[k]; upper[k] = p[k] > upper[k] ? p[k] : upper[k]; }
        }
        return lower[0] <= upper[0];
      }

      const uint8_t* end = nullptr; //!< of a step that is not raw

    private:
      /*! what there is of a step */
      struct Cells
      {
        bool isRaw;
        const float* origin;
        const uint32_t* corners;
        uint32_t first;          //!< word of the first cell
        const uint8_t* low;      //!< words of groups
        const uint8_t* high;     //!< or null
        const uint8_t* data;     //!< fields, or vertices if it is raw
        const VertStep* step;    //!< null of the first
        const void* start;       //!< of the block or of the step
        uint32_t remainders;     //!< their word; 0 if there are none

        VertSpacing spacing() const { return vertSpacing(first,corners); }

        uint32_t word(int g) const
        {
          if (g < 0) return first;
          const uint32_t lower = uint32_t(low[2*g]) | uint32_t(low[2*g+1]) << 8;
          return high ? lower | uint32_t(high[g]) << 16 : lower;
        }

        bool isTurned(int g) const { return step && (g < 0 ? isFirstCellTurned(step->boxForm) : cbvh::isTurned(step->turned,uint32_t(g))); }
      };

      static Cells cellsOf(const VertHeader* block, uint32_t step)
      {
        if (step == 0) {
          const VertLayout layout = vertLayout(block->region,block->boxForm);
          const uint8_t* data = (const uint8_t*)block;
          const bool raw = cbvh::isRaw(block->boxForm);
          return { raw,block->origin,block->corners,block->word,data+layout.words,data+layout.wordsHigh,data + (raw ? layout.vertices : layout.cell),nullptr,
                   block,hasRemainders(block->boxForm) ? remaindersAt(block,layout.remainders) : 0 };
        }
        const VertStep* of = stepOf(block,step);
        const VertStepLayout layout = vertStepLayout(block->region,of->boxForm);
        const uint8_t* data = (const uint8_t*)of;
        const bool raw = cbvh::isRaw(of->boxForm);
        return { raw,of->origin,of->corners,of->word,data+layout.words,hasUpperBits(of->boxForm) ? data+layout.wordsHigh : nullptr,data + (raw ? layout.vertices : layout.cell),of,
                 of,hasRemainders(of->boxForm) ? remaindersAt(of,layout.remainders) : 0 };
      }

      const uint8_t* bytes(uint32_t offset) const { return (const uint8_t*)block + offset; }

      /*! to vertices that are decoded without them */
      void addRemainders(const VertSpacing& spacing)
      {
        for (uint32_t i=0; i<(quadsX+1)*(quadsY+1); i++)
          for (int k=0; k<3; k++) {
            const uint32_t bits = remainderBits(cells.remainders,k);
            if (bits == 0) continue;
            const uint32_t word = bitsAt((const uint8_t*)cells.start,remainderBegin(cells.remainders,i,k),storedRemainderBits(cells.remainders,k));
            vertices[i][k] = withRemainder(vertices[i][k],word,bits,spacing.at[k]);
          }
      }

      /*! of a corner of groups, in spacings of the sheared axis */
      float sheared(uint32_t form, uint32_t corner) const
      {
        const int m = shearedAxis(form);
        const VertSpacing spacing = cells.spacing();
        return float(first[m][corner]) + shearFactor(form,1,spacing)*float(first[(m+1)%3][corner]) + shearFactor(form,2,spacing)*float(first[(m+2)%3][corner]);
      }

      /*! Vertices of a cell, by axis; data goes to the next one's. zero: the first step, from which it is turned, or null */
      void decodeCell(const Cells* zero, int g, const uint8_t*& data, const uint8_t*& dataOfZero, const int corners[3][4], uint32_t distance, uint32_t sideX, uint32_t sideY,
                      int out[3][cellVertices]) const
      {
        int residuals[3][cellVertices], ofZero[3][cellVertices];
        decodeResiduals(cells.word(g),data,residuals);
        data += cellBytes(cells.word(g));
        if (cells.step && !isRaw(block->boxForm)) {
          const Cells from = cellsOf(block,0);
          if (zero) decodeResiduals(from.word(g),dataOfZero,ofZero);
          dataOfZero += cellBytes(from.word(g));
        }
        for (int j=0; j<5; j++)
          for (int i=0; i<5; i++)
            for (int k=0; k<3; k++)
            {
              const int* c = corners[k];
              const int v = 5*j+i;
              out[k][v] = cellPrediction(c[0],c[1],c[2],c[3],cellWeight(i,int(distance),int(sideX)),cellWeight(j,int(distance),int(sideY))) + residuals[k][v];
              if (zero)
                out[k][v] += turnedResidual(turnEntry(*cells.step,uint32_t(3*k)),turnEntry(*cells.step,uint32_t(3*k+1)),turnEntry(*cells.step,uint32_t(3*k+2)),
                                            ofZero[0][v],ofZero[1][v],ofZero[2][v],turnShift(cells.step->turned));
            }
      }

      /*! up to 32 bits, from a bit on; reads no byte that has none of them */
      static uint32_t bitsAt(const uint8_t* data, uint32_t begin, uint32_t count)
      {
        uint32_t bits = 0;
        for (uint32_t b=0; b<count; b++) bits |= uint32_t((data[(begin+b) >> 3] >> ((begin+b) & 7)) & 1) << b;
        return bits;
      }

      /*! by axis */
      static void decodeResiduals(uint32_t word, const uint8_t* data, int out[3][cellVertices])
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
                residual[c] = cellResidual(bitsAt(data,uint32_t(begin),uint32_t(bits[c])),0,bits[c]) + (c == 0 ? 0 : slopeResidual(cellSlope(word,c),residual[0]));
              }
            }
            for (int c=0; c<3; c++) out[cellAxis(word,c)][5*j+i] = residual[c];
          }
      }

      const VertHeader* block;
      VertLayout layout;
      const Cells cells;
      int first[3][cellVertices];         //!< corners of groups
    };
  }}
}
