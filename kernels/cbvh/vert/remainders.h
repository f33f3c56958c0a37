// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Adds the remainders of cvert/format/block.h to the decoded vertices of a group, in the world, one after the other: few blocks have any. */

#include "cell_decoder.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! Receives the vertices of a cell in the world. */
      struct WorldVerticesOfCell
      {
        CellVertices& out;
        const VertSpacing& spacing;
        const float* origin;

        __forceinline void put (int axis, const CellVector& v) const { CoordinatesOfCell{ out }.put(axis,madd(v,spacing.at[axis],origin[axis])); }
      };

      /*! Adds their remainders to the vertices of group (gx,gy). start: of the block or step; remainders: their word */
      __noinline inline void addRemainders (const void* start, uint32_t remainders, const VertSpacing& spacing, uint32_t region, uint32_t gx, uint32_t gy,
                                            CellVertices& vertices)
      {
        const uint32_t quadsX = vertQuadsX(region), quadsY = vertQuadsY(region);
        for (int k=0; k<3; k++)
        {
          const uint32_t bits = remainderBits(remainders,k);
          if (bits == 0) continue;
          for (uint32_t j=0; j<5; j++)
            for (uint32_t i=0; i<5; i++) {
              const uint32_t vertex = min(groupQuads*gy+j,quadsY)*(quadsX+1) + min(groupQuads*gx+i,quadsX);
              const uint32_t bit = remainderBegin(remainders,vertex,k);
              uint64_t word; // may extend past the block, by less than readBehindVert
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
