// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Remainders of the vertices of a group, vert/format.h. Few blocks have them: they are added one by one, to vertices in the world. */

#include "cell_decoder.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! where vertices in the world go first, which have remainders */
      struct WorldVerticesOfCell
      {
        CellVertices& out;
        const VertSpacing& spacing;
        const float* origin;

        __forceinline void put (int axis, const CellVector& v) const { CoordinatesOfCell{ out }.put(axis,madd(v,spacing.at[axis],origin[axis])); }
      };

      /*! start: of a block or of a step; offset: of the word of remainders behind it; gx, gy: of the group */
      __noinline inline void addRemainders (const void* start, uint32_t offset, const VertSpacing& spacing, uint32_t region, uint32_t gx, uint32_t gy, CellVertices& vertices)
      {
        const uint32_t remainders = remaindersAt(start,offset), quadsX = vertQuadsX(region), quadsY = vertQuadsY(region);
        for (int k=0; k<3; k++)
        {
          const uint32_t bits = remainderBits(remainders,k);
          if (bits == 0) continue;
          for (uint32_t j=0; j<5; j++)
            for (uint32_t i=0; i<5; i++) {
              const uint32_t vertex = min(groupQuads*gy+j,quadsY)*(quadsX+1) + min(groupQuads*gx+i,quadsX);
              const uint32_t bit = remainderBegin(remainders,vertex,k);
              uint64_t word; // of which up to 39 bits are used: a block has more bytes behind it
              memcpy(&word,(const uint8_t*)start + (bit >> 3),sizeof(word));
              float& x = vertices.at[k][laneOfVertex(i,j)];
              x = withRemainder(x,uint32_t(word >> (bit & 7u)),bits,spacing.at[k]);
            }
#if !defined(__AVX512F__)
          for (int l=cellVertices; l<VertTables::lanes; l++) vertices.at[k][l] = vertices.at[k][cellVertices-1];
#endif
        }
      }
    }
  }
}
