// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decodes a block in scalar code, one time step at a time. This is the reference that SIMD decoders must equal. It is also the decoder for
 * programs that need all vertices of a block. */

#include "step_view.h"

namespace cvert { inline namespace CVERT_ISA
{
  /*! The vertices of a block at a time step, exactly as they were encoded. The block must be valid (validateVert), and exist as long as this. */
  class DecodedBlock
  {
  public:
    static const uint32_t maxSide = vertBlockQuads + 1u; //!< in vertices

    float vertices[maxSide*maxSide][3]; //!< world, row by row, (quadsX+1) (quadsY+1) of them
    const uint32_t quadsX, quadsY;

    /*! step: less than the number of steps of a block that moves, else 0 */
    explicit DecodedBlock(const VertHeader* block, uint32_t step = 0)
      : quadsX(vertQuadsX(block->region)), quadsY(vertQuadsY(block->region)), block(block), layout(vertLayout(block->region,block->boxForm)), view(block,layout,step)
    {
      if (view.isRaw()) {
        std::memcpy(vertices,view.data+view.vertices,sizeof(vertices[0])*(quadsX+1)*(quadsY+1));
        return;
      }
      decodeCells();
      if (hasRemainders(view.form)) addRemainders(remaindersAt(view.data,view.remainders));
    }

    const float* vertex(uint32_t x, uint32_t y) const { return vertices[y*(quadsX+1)+x]; }

    /*! Bounds of the finite vertices. Returns false if there are none. */
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

    /*! Box of a group in the world. On the sheared axis, lower and upper are sheared coordinates times the spacing, without the origin.
     *  form, margins: of the segment that begins or ends with this step; the block's own if they are left out */
    void groupBox(uint32_t g, float lower[3], float upper[3]) const { groupBox(g,block->boxForm,(const uint8_t*)block + layout.margins,lower,upper); }
    void groupBox(uint32_t g, uint32_t form, const uint8_t* margins, float lower[3], float upper[3]) const
    {
      if (view.isRaw()) {
        const float* planes = (const float*)((const uint8_t*)block + layout.boxes);
        for (uint32_t k=0; k<3; k++) { lower[k] = planes[k*layout.groups+g]; upper[k] = planes[(3+k)*layout.groups+g]; }
        return;
      }
      const VertSpacing spacing = vertSpacing(view.word,view.corners);
      for (int k=0; k<3; k++)
      {
        const uint32_t ofAxis = margins[k*int(layout.groups)+int(g)], shift = marginShift(form,k);
        const bool isSheared = k == shearedAxis(form);
        float lo = 0, hi = 0;
        for (uint32_t c=0; c<4; c++) {
          const uint32_t corner = cornerOfGroup(g,c);
          const float v = isSheared ? sheared(form,corner) : float(corners[k][corner]);
          lo = c == 0 || v < lo ? v : lo;
          hi = c == 0 || v > hi ? v : hi;
        }
        const float origin = isSheared ? 0.0f : view.origin[k];
        lower[k] = origin + (lo-float(lowerMargin(ofAxis,shift)))*spacing.at[k];
        upper[k] = origin + (hi+float(upperMargin(ofAxis,shift)))*spacing.at[k];
      }
    }

    /*! End of the fields and remainders; null for a raw step. */
    const uint8_t* end = nullptr;

  private:
    typedef int Coordinates[3][cellVertices]; //!< by axis, row by row

    struct Cell
    {
      int group;               //!< or -1, the first cell
      uint32_t distance;       //!< of neighboring vertices, in quads
      uint32_t quads[2];       //!< along its sides
      int corners[3][4];       //!< coordinates by axis
    };

    /*! Reads the residuals of the cells of a step, one cell after the other. */
    class ResidualReader
    {
    public:
      explicit ResidualReader(const StepView& view) : view(view), at(view.data+view.cell) {}

      void read(int group, Coordinates& out)
      {
        const uint32_t word = view.wordOf(group);
        const int bits[3] = { cellBits(word,0),cellBits(word,1),cellBits(word,2) }, sum = cellFieldBits(word);
        for (int j=0; j<5; j++)
          for (int i=0; i<5; i++)
          {
            int residual[3] = { 0,0,0 };
            const int f = cellField(i,j);
            for (int c=0, before=0; f>=0 && c<3; before+=bits[c++]) {
              const int begin = isByAxis(word) ? cellFields*before + f*bits[c] : f*sum + before;
              residual[c] = cellResidual(bitsAt(at,uint32_t(begin),uint32_t(bits[c])),0,bits[c]) + (c == 0 ? 0 : slopeResidual(cellSlope(word,c),residual[0]));
            }
            for (int c=0; c<3; c++) out[cellAxis(word,c)][5*j+i] = residual[c];
          }
        skip(group);
      }

      void skip(int group) { at += cellBytes(view.wordOf(group)); }

      const uint8_t* end() const { return at; }

    private:
      const StepView& view;
      const uint8_t* at; //!< fields of the next cell
    };

    void decodeCells()
    {
      const StepView firstStep(block,layout,0);
      ResidualReader residuals(view), ofFirstStep(firstStep);
      Cell cell = { -1,groupQuads,{ quadsX,quadsY },{} };
      for (int k=0; k<3; k++)
        for (int c=0; c<4; c++) cell.corners[k][c] = cornerCoordinate(view.corners[cornerPair(c,k)],c,k);
      decodeCell(cell,residuals,ofFirstStep,corners);
      const VertSpacing spacing = vertSpacing(view.word,view.corners);
      for (uint32_t g=0; g<layout.groups; g++)
      {
        const uint32_t gx = g % layout.groupsX, gy = g / layout.groupsX;
        cell = { int(g),1,{ quadsOfGroup(quadsX,gx),quadsOfGroup(quadsY,gy) },{} };
        for (int k=0; k<3; k++)
          for (uint32_t c=0; c<4; c++) cell.corners[k][c] = corners[k][cornerOfGroup(g,c)];
        Coordinates group;
        decodeCell(cell,residuals,ofFirstStep,group);
        for (uint32_t j=0; j<=cell.quads[1]; j++)
          for (uint32_t i=0; i<=cell.quads[0]; i++)
            for (int k=0; k<3; k++)
              vertices[(groupQuads*gy+j)*(quadsX+1) + groupQuads*gx+i][k] = view.origin[k] + float(group[k][5*j+i])*spacing.at[k];
      }
      end = residuals.end();
    }

    /*! Decodes the next cell of the readers. ofFirstStep: of the step from which residuals may be turned */
    void decodeCell(const Cell& cell, ResidualReader& residuals, ResidualReader& ofFirstStep, Coordinates& out) const
    {
      Coordinates residual, first;
      residuals.read(cell.group,residual);
      const bool isTurned = view.isTurned(cell.group);
      if (isTurned) ofFirstStep.read(cell.group,first);
      else if (view.later && !isRaw(block->boxForm)) ofFirstStep.skip(cell.group);
      for (int j=0; j<5; j++)
        for (int i=0; i<5; i++)
          for (int k=0; k<3; k++)
          {
            const int* c = cell.corners[k], v = 5*j+i;
            const int weightX = cellWeight(i,int(cell.distance),int(cell.quads[0])), weightY = cellWeight(j,int(cell.distance),int(cell.quads[1]));
            out[k][v] = cellPrediction(c[0],c[1],c[2],c[3],weightX,weightY) + residual[k][v];
            if (isTurned) out[k][v] += turned(uint32_t(k),first[0][v],first[1][v],first[2][v]);
          }
    }

    /*! Returns row k of the step's matrix times a residual of the first step. */
    int turned(uint32_t k, int x, int y, int z) const {
      const VertStep& step = *view.later;
      return turnedResidual(turnEntry(step,3*k),turnEntry(step,3*k+1),turnEntry(step,3*k+2),x,y,z,turnShift(step.turned));
    }

    void addRemainders(uint32_t remainders)
    {
      const VertSpacing spacing = vertSpacing(view.word,view.corners);
      for (uint32_t i=0; i<(quadsX+1)*(quadsY+1); i++)
        for (int k=0; k<3; k++) {
          const uint32_t bits = remainderBits(remainders,k);
          if (bits == 0) continue;
          const uint32_t word = bitsAt(view.data,remainderBegin(remainders,i,k),storedRemainderBits(remainders,k));
          vertices[i][k] = withRemainder(vertices[i][k],word,bits,spacing.at[k]);
        }
      end = view.data + remainderOffset(remainders) + bytesOfRemainders(remainders,block->region);
    }

    /*! Index of a corner of a group among the vertices of the first cell. */
    uint32_t cornerOfGroup(uint32_t g, uint32_t c) const { return 5*(g/layout.groupsX + (c >> 1)) + g % layout.groupsX + (c & 1); }

    /*! Returns a sheared coordinate, in spacings of the sheared axis. */
    float sheared(uint32_t form, uint32_t corner) const
    {
      const int m = shearedAxis(form);
      const VertSpacing spacing = vertSpacing(view.word,view.corners);
      return float(corners[m][corner]) + shearFactor(form,1,spacing)*float(corners[(m+1)%3][corner]) + shearFactor(form,2,spacing)*float(corners[(m+2)%3][corner]);
    }

    /*! Returns up to 32 bits from a bit on. Reads only bytes that contain one of them. */
    static uint32_t bitsAt(const uint8_t* data, uint32_t begin, uint32_t count)
    {
      uint32_t bits = 0;
      for (uint32_t b=0; b<count; b++) bits |= uint32_t((data[(begin+b) >> 3] >> ((begin+b) & 7)) & 1) << b;
      return bits;
    }

    const VertHeader* const block;
    const VertLayout layout;
    const StepView view;
    Coordinates corners; //!< vertices of the first cell
  };
}}
