// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The quads of a block in its frame: what the encoders of its nodes and leaves read.
 *
 * A cell is the part of the surface that a node of the finest level bounds: a quad, or, in a
 * block of a kind whose leaves are smaller (cLEAF of one quad), a part of one. */

#include "../codec/leaf.h"
#include "frame_fit.h"
#include "node_encoder.h"
#include <algorithm>
#include <cstring>

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    /*! area of a quad in the frame, relative to that of a leaf, below which it is much
     *  smaller: leaves 16 times as wide as their quads are no picture of them */
    static constexpr double minQuadArea = 1.0/256;

    class BlockGeometry
    {
    public:
      const uint32_t height;      //!< log2 of quads along a side
      const uint32_t width;       //!< vertices along a side
      const uint32_t cellLevels;  //!< log2 of cells along a side
      const float (*const vertices)[3]; //!< world positions
      Frame frame;
      InverseFrame inverse;
      double coordinate = 0;      //!< largest of the vertices
      double rounding[3];         //!< in the frame: how far vertices may be from where a neighbouring face has them
      ExactBox* boxes;            //!< of all quadtree levels down to cells, level by level
      double (*local)[3];         //!< vertices of cells, in the frame
      uint32_t invalidQuads = 0;  //!< with a vertex that is not finite

      /*! bytes of scratch memory for blocks of this height, 16-byte aligned */
      static size_t scratchBytes(uint32_t height) {
        BlockGeometry geometry(Kind::LEAF,height,nullptr,nullptr); // cells of every kind, and more
        return geometry.layoutScratch(nullptr);
      }

      /*! vertices: (2^height+1)^2 world positions, row by row, kept by reference;
       *  scratch: see scratchBytes, kept by reference */
      BlockGeometry(Kind kind, uint32_t height, const float (*vertices)[3], void* scratch)
        : height(height), width((1u << height)+1), cellLevels(std::max(height,kindFormats[uint32_t(kind)].minNodeLevels)),
          vertices(vertices) { layoutScratch((char*)scratch); }

      /*! Fits the block's frame; false when nothing is left to encode: no quad is
       *  finite, or floats cannot hold a frame.
       *  corners: world positions to align to, (0,0), (1,0), (0,1), (1,1) */
      bool fit(const float corners[4][3])
      {
        size_t count = 0;
        for (uint32_t i=0; i<width*width; i++)
          if (isFinite(i)) { memcpy(finite[count++],vertices[i],sizeof(float[3])); }
        if (count == 0) return false;
        allFinite = count == width*width;

        float aligned[4][3];
        memcpy(aligned,corners,sizeof(aligned));
        bool ok = true;
        for (int c=0; c<4; c++) ok &= cbvh::isFinite(corners[c]);
        if (!ok) /* no corners to align to: any frame around the vertices */
          for (int c=0; c<4; c++) memcpy(aligned[c],finite[size_t(c)*(count-1)/3],sizeof(float[3]));
        if (!fitFrame(aligned,finite,count,fitted,frame)) return false;
        for (uint32_t i=0; i<width*width; i++)
          frame.transform(vertices[i],local[i]);
        if (cellLevels > height) splitQuad();
        return true;
      }

      /*! Whether leaves would be much larger than most of their quads: the vertices lie on
       *  a line, or some are far away from all others. Better not compressed. */
      bool isDegenerate() const
      {
        const uint32_t cells = 1u << (2*cellLevels);
        uint32_t small = 0, valid = 0;
        for (uint32_t m=0; m<cells; m++)
        {
          const double* q[4];
          for (int c=0; c<4; c++) q[c] = local[vertexOfCell(m,c)];
          const double area = 0.5*std::fabs((q[3][0]-q[0][0])*(q[2][1]-q[1][1]) - (q[3][1]-q[0][1])*(q[2][0]-q[1][0]));
          small += area*cells < minQuadArea;
          valid += area >= 0; // not NaN
        }
        return frame.degenerate || 2*small > valid;
      }

      /*! bounds the cells and all nodes above them; after fit */
      void bound()
      {
        inverse = InverseFrame(frameMap(frame.columns));
        boundRounding();
        uint32_t invalid = 0;
        for (uint32_t m=0; m < 1u << (2*cellLevels); m++)
          invalid += !boundCell(m);
        invalidQuads = cellLevels > height ? invalid != 0 : invalid;
        for (uint32_t level=cellLevels; level-- > 0;)
          for (uint32_t m=0; m < 1u << (2*level); m++)
          {
            ExactBox box;
            for (uint32_t c=0; c<4; c++) box.extend(boxOf(level+1,4*m+c));
            boxOf(level,m) = box;
          }
      }

      ExactBox& boxOf(uint32_t level, uint32_t m) { return boxes[nodesOfLevels(level)+m]; }
      const ExactBox& boxOf(uint32_t level, uint32_t m) const { return boxes[nodesOfLevels(level)+m]; }

      bool isFinite(uint32_t i) const { return cbvh::isFinite(vertices[i]); }

    private:
      /*! places the arrays in scratch memory; returns the end */
      size_t layoutScratch(char* scratch)
      {
        const size_t side = (size_t(1) << cellLevels) + 1, points = side*side;
        size_t bytes = 0;
        auto take = [&](size_t n) { const uintptr_t p = uintptr_t(scratch) + bytes; bytes += (n+15) & ~size_t(15); return p; };
        boxes  = (ExactBox*)take(nodesOfLevels(cellLevels+1)*sizeof(ExactBox));
        local  = (double(*)[3])take(points*3*sizeof(double));
        fitted = (Double3*)take(points*sizeof(Double3));
        finite = (float(*)[3])take(points*3*sizeof(float));
        return bytes;
      }

      /*! whether a vertex in the frame, of a cell, is finite */
      bool isLocalFinite(uint32_t i) const { return std::isfinite(local[i][0]) && std::isfinite(local[i][1]) && std::isfinite(local[i][2]); }

      uint32_t vertexOfCell(uint32_t m, int corner) const {
        return (mortonY(m)+(corner>>1))*((1u << cellLevels)+1) + mortonX(m)+(corner&1);
      }

      /*! one quad as 2 x 2 cells */
      void splitQuad()
      {
        double quad[4][3];
        memcpy(quad,local,sizeof(quad));
        for (int v=0; v<9; v++)
          for (int k=0; k<3; k++)
            local[v][k] = 0.25*((2-v%3)*((2-v/3)*quad[0][k] + (v/3)*quad[2][k]) + (v%3)*((2-v/3)*quad[1][k] + (v/3)*quad[3][k]));
      }

      /*! vertexRounding in the frame, axis by axis: a world step of r on each axis moves
       *  x = X/W by at most r (|dX| + |dW|)/W */
      void boundRounding()
      {
        double rcpW = 0;
        coordinate = 0;
        for (uint32_t i=0; i<width*width; i++)
          for (int k=0; k<3; k++)
            if (isFinite(i)) coordinate = std::max(coordinate,std::fabs(double(vertices[i][k])));
        for (int corner=0; corner<8; corner++)
          rcpW = std::max(rcpW,inverse.rcpW({ double(corner&1),double((corner>>1)&1),double(corner>>2) }));
        auto sum = [&](int k) { return std::fabs(double(frame.columns[0][k])) + std::fabs(double(frame.columns[1][k])) + std::fabs(double(frame.columns[2][k])); };
        for (int k=0; k<3; k++)
          rounding[k] = vertexRounding*coordinate*(sum(k)+sum(3))*rcpW;
      }

      /*! false for a cell with a vertex that is not finite: its box is empty */
      bool boundCell(uint32_t m)
      {
        ExactBox box;
        bool valid = true;
        for (int c=0; c<4; c++) {
          const uint32_t i = vertexOfCell(m,c);
          valid &= allFinite || isLocalFinite(i);
          if (valid) box.extend(local[i]);
        }
        for (int k=0; k<3; k++) {
          box.lower[k] = std::min(box.lower[k],std::max(box.lower[k]-rounding[k],frameMargin));
          box.upper[k] = std::max(box.upper[k],std::min(box.upper[k]+rounding[k],1-frameMargin));
        }
        boxOf(cellLevels,m) = valid ? box : ExactBox();
        return valid;
      }

    private:
      bool allFinite = false;
      Double3* fitted;          //!< vertices, relative, while the frame is fitted
      float (*finite)[3];
    };
  }}
}
