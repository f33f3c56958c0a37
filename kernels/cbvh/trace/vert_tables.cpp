// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "vert_tables.h"
#include "../codec/vert_block.h"

#include <algorithm>

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
      for (int bits=0; bits<=maxWindowBits; bits++)
        if (hasWindows(bits)) setWindows(bits);
    }

    void VertTables::setWindows (int bits)
    {
      Windows& w = windows[bits];
      const int end = (cellFields*bits+7)/8;
      for (int window=0; window<lanes/4; window++)
      {
        int first = end;
        for (int l=4*window; l<4*window+4; l++)
          if (l < cellVertices && hasField[l]) first = std::min(first,field[l]*bits/8);
        const int offset = std::max(std::min(first,end+readBehind-16),0);
        w.offset[window] = uint8_t(offset);
        for (int l=4*window; l<4*window+4; l++)
        {
          const bool has = l < cellVertices && hasField[l];
          const int bit = field[l]*bits;
          const int zero = 0x80; // what the shuffle makes of it
          for (int byte=0; byte<4; byte++) {
            w.control[window][4*(l & 3)+byte] = uint8_t(has ? bit/8-offset+byte : zero);
            w.fifth[window][4*(l & 3)+byte] = uint8_t(has && byte == 0 && bit % 8 + bits > 32 ? bit/8-offset+4 : zero);
          }
          w.shift[l] = bit % 8;
          w.factor[l] = 1 << (7-bit % 8);
        }
      }
    }

    const VertTables vertTables;
  }
}
