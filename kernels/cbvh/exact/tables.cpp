// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest instruction set, because it runs when the library is loaded. */

#include "tables.h"
#include "../base/codec_names.h"
#include "../../cvert/rule/rule.h"

#include <algorithm>

namespace embree::cbvh {
VertTables::VertTables() {
  for (int lane = 0; lane < lanes; lane++) {
    const bool isVertex = lane < cellVertices;
    const int i = lane < 20 ? lane % 4 : 4, j = lane < 20 ? lane / 4 : isVertex ? lane - 20 : 4;
    for (int quads = 1; quads <= 16; quads++)
      for (int isGroup = 0; isGroup < 2; isGroup++) {
        const int quadsPerVertex = isGroup ? 1 : int(groupQuads);
        weightX[isGroup][quads - 1][lane] = float(cellWeight(i, quadsPerVertex, quads)) / 16.0f;
        weightY[isGroup][quads - 1][lane] = float(cellWeight(j, quadsPerVertex, quads)) / 16.0f;
      }
    const int f = cellField(i, j);
    field[lane] = f < 0 ? 0 : f;
    hasField[lane] = f < 0 ? 0 : -1;
    if (f >= 0) laneOfField[f] = uint8_t(lane);
  }
  for (uint32_t q = 0; q < 16; q++)
    for (uint32_t c = 0; c < 4; c++) corners[q][c] = uint8_t(laneOfCorner(q, c));
  for (uint32_t index = 0; index < 32; index++)
    for (int i = 0; i < 4; i++)
      triangles[index][i] = i < 3 ? corners[index >> 1][cornerOfTriangle(index, i)] : uint8_t(0);
  for (int bits = 0; bits <= maxWindowBits; bits++)
    if (hasWindows(bits)) setWindows(bits);
}

void VertTables::setWindows(int bits) {
  Windows& w = windows[bits];
  const int end = (cellFields * bits + 7) / 8;
  for (int row = 0; row < Windows::rows; row++) {
    int first = end;
    for (int l = 4 * row; l < 4 * row + 4; l++)
      if (hasField[l]) first = std::min(first, field[l] * bits / 8);
    const int offset = std::max(std::min(first, end + maxOverread - 16), 0);
    w.offset[row] = uint8_t(offset);
    for (int l = 4 * row; l < 4 * row + 4; l++) {
      const int bit = field[l] * bits;
      const int zero = 0x80; // selects no byte: the shuffle writes 0
      for (int byte = 0; byte < 4; byte++) {
        w.shuffle[row][4 * (l & 3) + byte] = uint8_t(hasField[l] ? bit / 8 - offset + byte : zero);
        w.shuffleFifthByte[row][4 * (l & 3) + byte] =
            uint8_t(hasField[l] && byte == 0 && bit % 8 + bits > 32 ? bit / 8 - offset + 4 : zero);
      }
      w.shift[l] = bit % 8;
      w.factor[l] = 1 << (7 - bit % 8);
    }
    const int bit = field[laneOfVertex(4, row)] * bits;
    w.columnOffset[row] = uint8_t(bit / 8);
    w.columnShift[row] = uint8_t(bit % 8);
  }
}

const VertTables vertTables;
} // namespace embree::cbvh
