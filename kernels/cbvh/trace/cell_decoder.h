// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoder of a cell of cVERT, codec/vertex_cell.h, all vertices of an axis at a time. Floats hold
 * every number here exactly, so this equals the codec's integers, fused or not. */

#include "quad_corners.h"
#include "vert_cache.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! Corners of a cell, floats that are integers: 00, 10, 01, 11, each of three axes. */
      struct CellCorners
      {
        const float* first;   //!< numbers of the first axis
        int step;             //!< to those of the next
        const uint8_t* place; //!< of each corner's number

        __forceinline vfloatV at (int axis, int corner) const { return vfloatV(first[step*axis + place[corner]]); }
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

        __forceinline vfloatV at (const vfloatV& x, const vfloatV& y) const {
          return k + floor(madd(madd(dxy,y,dx),x,madd(dy,y,vfloatV(0.5f))));
        }
      };

      /*! where vertices go: coordinates of the block as they are, or corners of quads in the world */
      struct CoordinatesOfCell
      {
        CellVertices& out;

        __forceinline void put (int axis, const CellVector& v) const
        {
          for (int n=0; n<fieldVectors; n++) vfloatV::store(out.at[axis]+vectorWidth*n,v.at[n]);
#if !defined(__AVX512F__)
          vfloatV::store(out.at[axis]+vectorWidth*fieldVectors,v.last);
#endif
        }
      };

      struct WorldOfCell
      {
        QuadCorners& out;
        const float spacing;
        const float* origin;

        __forceinline void put (int axis, const CellVector& v) const
        {
          const QuadCornersV corners(madd(v,spacing,origin[axis]));
          for (int c=0; c<4; c++)
            for (int j=0; j<QuadCornersV::vectors; j++) vfloatV::store(out.at[c][axis]+vectorWidth*j,corners.at(j,c));
        }
      };

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
          CellVector v(corners.at(axis,3));
          for (int c=0; c<fieldVectors; c++)
          {
            const vfloatV x = vfloatV::load(weightX+vectorWidth*c), y = vfloatV::load(weightY+vectorWidth*c);
            vfloatV residual = residualOf(fields.lanes[c],0,bits);
            if (i == 0) main[c] = residual;
            else residual = residual + floor(madd(vfloatV(slope),main[c],vfloatV(0.5f)));
            v.at[c] = prediction.at(x,y) + residual;
          }
          out.put(axis,v);
        }
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
        vfloatV main[fieldVectors];
        for (int i=0, shift=0; i<3; shift+=cellBits(word,i++))
        {
          const int bits = cellBits(word,i), axis = cellAxis(word,i);
          const vfloatV slope(i == 0 ? 0.0f : float(cellSlope(word,i))*(1.0f/16.0f));
          const CellPrediction prediction(corners,axis);
          CellVector v(corners.at(axis,3));
          for (int c=0; c<fieldVectors; c++)
          {
            vfloatV residual = residualOf(fields.lanes[c],shift,bits);
            if (i == 0) main[c] = residual;
            else residual = residual + floor(madd(slope,main[c],vfloatV(0.5f)));
            v.at[c] = prediction.at(vfloatV::load(weightX+vectorWidth*c),vfloatV::load(weightY+vectorWidth*c)) + residual;
          }
          out.put(axis,v);
        }
      }
    }
  }
}
