// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The vertices of a block of cVERT at one time, and their coordinates on its lattice. */

#include "format.h"
#include "cell_encoder.h"
#include "../base/vertices4.h"
#include <algorithm>

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    class BlockVertices
    {
    public:
      static const uint32_t maxSide = (1u << maxVertHeight) + 1u;
      static const uint32_t maxVertices = maxSide*maxSide + 3; //!< with whole vectors of four

      float vertices[maxVertices][3]; //!< row by row, (quadsX+1) (quadsY+1) of them
      float lower[3], upper[3];       //!< of the finite ones; if there is none, infinity and -infinity
      bool allFinite;
      float spacing;                  //!< of the lattice that the coordinates are of

      uint32_t quads[2], width;
      int coordinates[3][maxVertices]; //!< behind the last, to whole vectors, those of the first

      void setSize (uint32_t region) { quads[0] = vertQuadsX(region); quads[1] = vertQuadsY(region); width = quads[0]+1; }

      uint32_t numVertices () const { return width*(quads[1]+1); }
      const float* vertexAt (uint32_t x, uint32_t y) const { return vertices[y*width+x]; }
      bool anyFinite () const { return lower[0] <= upper[0]; }

      void bound ()
      {
        allFinite = boundVertices(vertices,numVertices(),lower,upper);
        if (allFinite) return;
        for (int k=0; k<3; k++) { lower[k] = INFINITY; upper[k] = -INFINITY; }
        for (uint32_t i=0; i<numVertices(); i++)
        {
          if (!isFinite(vertices[i])) continue;
          for (int k=0; k<3; k++) { lower[k] = std::min(lower[k],vertices[i][k]); upper[k] = std::max(upper[k],vertices[i][k]); }
        }
      }

      /*! with a vertex that is not finite */
      uint32_t countInvalidQuads () const
      {
        uint32_t n = 0;
        for (uint32_t y=0; y<quads[1]; y++)
          for (uint32_t x=0; x<quads[0]; x++)
            n += !(isFinite(vertexAt(x,y)) && isFinite(vertexAt(x+1,y)) && isFinite(vertexAt(x,y+1)) && isFinite(vertexAt(x+1,y+1)));
        return n;
      }

      /*! coordinates on the lattice relative to the lower bounds; false where one is too large */
      bool locate (float spacing)
      {
        for (int k=0; k<3; k++)
          if (!((double(upper[k])-double(lower[k])) < double(maxExtent)*spacing)) return false;
        this->spacing = spacing;
        const Float4 unit = spacing, reciprocal = 1.0f/spacing; // a power of two
        uint32_t off = 0; // this lattice
        auto locate = [&](Float4 x) {
          const Int4 c = truncated(x*reciprocal);
          off |= ~lanesEqual(toFloat(c)*unit,x);
          return c;
        };
        const Int4 first[3] = { locate(lower[0]),locate(lower[1]),locate(lower[2]) };
        for (uint32_t i=numVertices(); i % 4 != 0; i++) memcpy(vertices[i],vertices[0],sizeof(vertices[0]));
        for (uint32_t i=0; i<numVertices(); i+=4)
        {
          const Vertices4 p(vertices+i);
          (locate(p.x)-first[0]).store(coordinates[0]+i);
          (locate(p.y)-first[1]).store(coordinates[1]+i);
          (locate(p.z)-first[2]).store(coordinates[2]+i);
        }
        return (off & 15) == 0;
      }

      /*! of the vertices of a cell; those behind the last are the last */
      void gather (const int* values, uint32_t x0, uint32_t y0, uint32_t step, int out[paddedVertices]) const
      {
        for (uint32_t j=0; j<5; j++)
        {
          const int* row = values + std::min(y0+step*j,quads[1])*width;
          if (step == 1 && x0+4 <= quads[0]) { memcpy(out+5*j,row+x0,5*sizeof(*row)); continue; }
          for (uint32_t i=0; i<5; i++) out[5*j+i] = row[std::min(x0+step*i,quads[0])];
        }
        for (int v=cellVertices; v<paddedVertices; v++) out[v] = out[cellVertices-1];
      }

      /*! Vertices as floats; what is not finite is not a number: a triangle with that is never hit, one with infinity might be. */
      void copyTo (float (*out)[3]) const
      {
        for (uint32_t i=0; i<numVertices(); i++)
          for (int k=0; k<3; k++) out[i][k] = isFinite(vertices[i]) ? vertices[i][k] : NAN;
      }

      static uint32_t exponentBits (float spacing)
      {
        uint32_t bits;
        memcpy(&bits,&spacing,sizeof(bits));
        return (bits >> 23) << 24;
      }
    };
  }}
}
