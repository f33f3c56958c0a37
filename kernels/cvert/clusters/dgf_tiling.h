// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Divides a rectangle of quads into blocks of DGF: bands of rows, divided into pieces as wide as a block allows.
 * Chooses the bands with the fewest blocks. */

#include "dgf.h"

namespace cvert { namespace dgf {
class Tiling {
public:
  /*! points: must outlive this object. quadsX, quadsY: up to 16. Dynamic programming over the rows. */
  Tiling(const LatticePoints& points, uint32_t quadsX, uint32_t quadsY)
    : points(points),
      quadsX(quadsX),
      quadsY(quadsY) {
    const uint32_t none = ~0u;
    for (uint32_t y = 1; y <= quadsY; y++) blocks[y] = none;
    blocks[0] = 0;
    for (uint32_t y = 0; y < quadsY; y++) {
      if (blocks[y] == none) continue;
      Columns columns(points, quadsX, y);
      for (uint32_t height = 1; y + height <= quadsY; height++) {
        columns.add(y + height);
        uint32_t count = 0;
        if (!forEachPiece(columns, height, [&](uint32_t, uint32_t) { count++; })) break;
        if (blocks[y] + count >= blocks[y + height]) continue;
        blocks[y + height] = blocks[y] + count;
        heights[y + height] = height;
      }
    }
    isPossible = blocks[quadsY] != none;
  }

  bool isPossible; //!< false if a quad is too large for a block

  /*! Calls closure(x,y,width,height) for each piece, in quads. Requires isPossible. */
  template<typename Closure>
  void forEach(const Closure& closure) const {
    uint32_t ends[LatticePoints::maxSide], n = 0;
    for (uint32_t y = quadsY; y > 0; y -= heights[y]) ends[n++] = y;
    while (n-- > 0) {
      const uint32_t height = heights[ends[n]], y = ends[n] - height;
      Columns columns(points, quadsX, y);
      for (uint32_t i = 1; i <= height; i++) columns.add(y + i);
      forEachPiece(columns, height, [&](uint32_t x, uint32_t width) { closure(x, y, width, height); });
    }
  }

private:
  /*! Bounds of the columns of vertices of a band. */
  struct Columns {
    LatticeSpan spans[LatticePoints::maxSide];
    const LatticePoints& points;
    const uint32_t count;

    Columns(const LatticePoints& points, uint32_t quadsX, uint32_t y) : points(points), count(quadsX + 1) { add(y); }

    void add(uint32_t y) {
      for (uint32_t x = 0; x < count; x++)
        if (points.isPresent[y * points.width + x]) spans[x].add(points.at[y * points.width + x]);
    }
  };

  /*! Calls closure(x,width) for the pieces of a band of `height` rows. Returns false if a column of quads does not
   *  fit into a block. */
  template<typename Closure>
  bool forEachPiece(const Columns& columns, uint32_t height, const Closure& closure) const {
    for (uint32_t x = 0, width; x < quadsX; x += width) {
      LatticeSpan span = columns.spans[x];
      for (width = 0; x + width < quadsX; width++) {
        LatticeSpan wider = span;
        wider.add(columns.spans[x + width + 1]);
        if (!hasRoomForQuads(width + 1, height, wider)) break;
        span = wider;
      }
      if (width == 0) return false;
      closure(x, width);
    }
    return true;
  }

  const LatticePoints& points;
  const uint32_t quadsX, quadsY;
  //! by row: least number of blocks for all rows before it, and height of the last band before it
  uint32_t blocks[LatticePoints::maxSide], heights[LatticePoints::maxSide];
};
}} // namespace cvert::dgf
