// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Remainders of the vertices of a group, vert/format.h, and what they add to its vertices in the world. Few blocks have them: they are read one
 * by one. */

#include "cell_decoder.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      class CellRemainders
      {
      public:
        /*! start: of a block or of a step; offset: of the word of remainders behind it; gx, gy: of the group */
        __noinline CellRemainders (const void* start, uint32_t offset, const VertSpacing& spacing, uint32_t region, uint32_t gx, uint32_t gy)
        {
          const uint32_t remainders = remaindersAt(start,offset), quadsX = vertQuadsX(region), quadsY = vertQuadsY(region);
          for (int k=0; k<3; k++)
          {
            const uint32_t bits = remainderBits(remainders,k);
            const float unit = remainderSpacing(spacing.at[k],bits);
            for (uint32_t l=cellVertices; l<VertTables::lanes; l++) at[k][l] = 0.0f;
            for (uint32_t j=0; j<5; j++)
              for (uint32_t i=0; i<5; i++) {
                const uint32_t vertex = min(groupQuads*gy+j,quadsY)*(quadsX+1) + min(groupQuads*gx+i,quadsX);
                at[k][laneOfVertex(i,j)] = float(remainderAt(start,remainderBegin(remainders,vertex,k),bits))*unit;
              }
          }
        }

        __forceinline CellVector along (int axis) const { return CellVector(at[axis]); }

      private:
        alignas(64) float at[3][VertTables::lanes]; //!< in the world
      };

      /*! where vertices in the world go, which have remainders. Out: as WorldOfCell */
      template<typename Out>
      struct WithRemainders
      {
        const Out out;
        const CellRemainders& remainders;

        /*! Both sums are exact: see format.h. */
        __forceinline void put (int axis, const CellVector& v) const { out.store(axis,madd(v,out.spacing.at[axis],out.origin[axis]) + remainders.along(axis)); }
      };
    }
  }
}
