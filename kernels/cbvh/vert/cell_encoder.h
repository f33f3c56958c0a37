// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of a cell of cVERT, vert/cell.h: 5 x 5 vertices of integers become a word
 * and fields. */

#include "cell.h"
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    class CellEncoder
    {
    public:
      int vertices[3][cellVertices]; //!< coordinates by axis, row by row; less than maxExtent, not negative

      /*! quads: along u and v; step: of them from one vertex to the next. False where a residual
       *  takes more bits than a cell has. */
      bool encode (const uint32_t quads[2], uint32_t step)
      {
        predict(quads,step);
        const int main = mainAxis();
        int bits[3] = { bitsOf(residuals[main]),0,0 };
        int slopes[3] = { 0,0,0 };
        for (int i=1; i<3; i++) slopes[i] = removeSlope(residuals[main],residuals[(main+i)%3],bits[i]);
        for (int i=0; i<3; i++)
          if (bits[i] > maxResidualBits) return false;
        word = uint32_t(bits[0]) | uint32_t(bits[1]) << 4 | uint32_t(bits[2]) << 8 | uint32_t(main) << 12
             | (uint32_t(slopes[1]) & 31u) << 14 | (uint32_t(slopes[2]) & 31u) << 19;
        return true;
      }

      uint32_t word;

      /*! the fields of the cell that encode took; returns the end */
      uint8_t* write (uint8_t* out) const
      {
        const int main = cellMainAxis(word), sum = cellFieldBits(word);
        const int bits[3] = { cellBits(word,0),cellBits(word,1),cellBits(word,2) };
        const int* component[3] = { residuals[main],residuals[cellAxis(word,1)],residuals[cellAxis(word,2)] };
        BitWriter writer = { out };
        auto residual = [&](int i, int v) { return uint32_t(component[i][v]) & ((1u << bits[i])-1u); };
        if (isByAxis(word)) {
          for (int i=0; i<3; i++)
            for (int v=0; v<cellVertices; v++)
              if (!isCorner(v)) writer.put(residual(i,v),bits[i]);
        }
        else {
          for (int v=0; v<cellVertices; v++)
            if (!isCorner(v))
              writer.put(residual(0,v) | residual(1,v) << bits[0] | uint32_t(uint64_t(residual(2,v)) << (bits[0]+bits[1])),sum);
        }
        return writer.end();
      }

    private:
      struct BitWriter
      {
        uint8_t* out;
        uint64_t pending = 0;
        int count = 0;

        BitWriter (uint8_t* out) : out(out) {}

        void put (uint32_t field, int bits)
        {
          pending |= uint64_t(field) << count; // at most 7 + 32 bits
          for (count += bits; count >= 8; count -= 8) { *out++ = uint8_t(pending); pending >>= 8; }
        }

        uint8_t* end ()
        {
          if (count > 0) *out++ = uint8_t(pending);
          return out;
        }
      };

      static bool isCorner (int v) { return v == 0 || v == 4 || v == 20 || v == 24; }

      void predict (const uint32_t quads[2], uint32_t step)
      {
        int x[5], y[5];
        for (int i=0; i<5; i++) { x[i] = cellWeight(i,int(step),int(quads[0])); y[i] = cellWeight(i,int(step),int(quads[1])); }
        for (int k=0; k<3; k++)
        {
          const int* c = vertices[k];
          const int c00 = c[0], c10 = c[4], c01 = c[20], c11 = c[24];
          for (int j=0; j<5; j++)
            for (int i=0; i<5; i++)
              residuals[k][5*j+i] = c[5*j+i] - cellPrediction(c00,c10,c01,c11,x[i],y[j]);
        }
      }

      /*! along which residuals are largest */
      int mainAxis () const
      {
        float sums[3];
        for (int k=0; k<3; k++) {
          float sum = 0;
          for (int v=0; v<cellVertices; v++) sum += float(residuals[k][v])*float(residuals[k][v]);
          sums[k] = sum;
        }
        return sums[0] >= sums[1] && sums[0] >= sums[2] ? 0 : sums[1] >= sums[2] ? 1 : 2;
      }

      /*! bits of the largest residual; those of corners are 0 */
      static int bitsOf (const int r[cellVertices])
      {
        int used = 0;
        bool any = false;
        for (int v=0; v<cellVertices; v++) { used |= r[v] ^ (r[v] >> 31); any |= r[v] != 0; }
        int bits = any ? 1 : 0;
        while (used) { bits++; used >>= 1; }
        return bits;
      }

      /*! Takes the slope that fits best out of a component, if that saves bits; returns it. */
      static int removeSlope (const int main[cellVertices], int r[cellVertices], int& bits)
      {
        bits = bitsOf(r);
        float mm = 0, mr = 0;
        for (int v=0; v<cellVertices; v++) { mm += float(main[v])*float(main[v]); mr += float(main[v])*float(r[v]); }
        if (!(mm > 0) || bits == 0) return 0;
        const float fit = 16*mr/mm;
        const int slope = fit < -maxSlope ? -maxSlope : fit > maxSlope ? maxSlope : int(std::floor(fit+0.5f));
        if (slope == 0) return 0;
        int rest[cellVertices];
        for (int v=0; v<cellVertices; v++) rest[v] = r[v] - slopeResidual(slope,main[v]);
        const int restBits = bitsOf(rest);
        if (restBits >= bits) return 0;
        memcpy(r,rest,sizeof(rest));
        bits = restBits;
        return slope;
      }

      int residuals[3][cellVertices];
    };
  }}
}
