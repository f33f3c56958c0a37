// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "vert_tables.h"
#include "../codec/vert_block.h"

namespace embree
{
  namespace cbvh
  {
    VertTables::VertTables ()
    {
      for (int lane=0; lane<lanes; lane++)
      {
        const int v = lane < cellVertices ? lane : 0, i = v % 5, j = v / 5;
        for (int quads=1; quads<=16; quads++)
          for (int kind=0; kind<2; kind++)
          {
            const int step = kind ? 1 : int(groupQuads);
            weightX[kind][quads-1][lane] = float(cellWeight(i,step,quads))/16.0f;
            weightY[kind][quads-1][lane] = float(cellWeight(j,step,quads))/16.0f;
          }
        const int f = cellField(i,j);
        field[lane] = f < 0 ? 0 : f;
        hasField[lane] = f < 0 ? 0 : -1;
        if (f >= 0 && lane < cellVertices) laneOfField[f] = uint8_t(lane);
      }
    }

    const VertTables vertTables;
  }
}
