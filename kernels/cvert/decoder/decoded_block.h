// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decodes all vertices of a cVERT block or tile: the reference for the kernels' SIMD decoders. */

#include "../format/tile.h"
#include "cell_vertices.h"
#include "group_planes.h"

namespace cvert { inline namespace CVERT_ISA {
/*! Vertices of a block or tile at a time step. SIMD decoders must return the same floats. The block must be valid
 *  (validateVert) and outlive this object. Reads up to vertReadPadding bytes after the block. */
class DecodedBlock {
public:
  static const uint32_t maxSide = vertBlockQuads + 1u; //!< vertices per side

  float vertices[maxSide * maxSide][3]; //!< in world space, row by row, quadsX+1 per row
  const uint32_t quadsX, quadsY;

  /*! step: below the number of steps; 0 unless the block moves */
  explicit DecodedBlock(const VertHeader* block, uint32_t step = 0)
    : quadsX(vertQuadsX(block->region)),
      quadsY(vertQuadsY(block->region)),
      block(block),
      layout(vertLayout(block->region, block->info)),
      view(viewOfStep(block, layout, isTile(block->info) ? 0 : step)) {
    if (isTile(block->info)) decodeTile(tileOfStep(block, step));
    else if (isRaw(view.info))
      std::memcpy(vertices, view.data + view.vertices, sizeof(vertices[0]) * (quadsX + 1) * (quadsY + 1));
    else decode();
  }

  const float* vertex(uint32_t x, uint32_t y) const { return vertices[y * (quadsX + 1) + x]; }

  /*! Bounds of the finite vertices. Returns false if there are none. */
  bool bounds(float lower[3], float upper[3]) const {
    for (int k = 0; k < 3; k++) {
      lower[k] = INFINITY;
      upper[k] = -INFINITY;
    }
    for (uint32_t i = 0; i < (quadsX + 1) * (quadsY + 1); i++) {
      const float* p = vertices[i];
      if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))) continue;
      for (int k = 0; k < 3; k++) {
        lower[k] = p[k] < lower[k] ? p[k] : lower[k];
        upper[k] = p[k] > upper[k] ? p[k] : upper[k];
      }
    }
    return lower[0] <= upper[0];
  }

  /*! Box of group g at the step, see BoxPlanes. Tiles have none. Later steps that are raw have none; steps that are not
   * raw have none in a segment whose other end is raw. info, margins: of the step at which the segment begins; the
   * decoded step may be at either end. margins: see VertLayout. Without info and margins, the box is of the first
   * segment, so the step must be 0 or 1. */
  void groupBox(uint32_t g, float lower[3], float upper[3]) const {
    groupBox(g, block->info, (const uint8_t*)block + layout.margins, lower, upper);
  }
  void groupBox(uint32_t g, uint32_t info, const uint8_t* margins, float lower[3], float upper[3]) const {
    for (int k = 0; k < 3; k++) {
      const BoxPlanes planes =
          isRaw(view.info) ? rawPlanesOfGroup(block, layout, g, k)
                           : planesOfGroup(view, info, corners[cornerOfGroup(g, 0)], corners[cornerOfGroup(g, 1)],
                                           corners[cornerOfGroup(g, 2)], corners[cornerOfGroup(g, 3)],
                                           margins[uint32_t(k) * layout.groups + g], k);
      lower[k] = planes.lower;
      upper[k] = planes.upper;
    }
  }

  /*! End of the step's fields and remainders; null for a raw step. */
  const uint8_t* end = nullptr;

private:
  /*! A cell of the first step, whose rotated residuals the current step adds to its own. */
  struct FirstFields {
    bool isRotated;
    uint32_t word, fields; //!< see CodedCell
  };

  void decodeTile(const VertHeader* tile) {
    for (uint32_t y = 0; y <= quadsY; y++)
      for (uint32_t x = 0; x <= quadsX; x++)
        for (int k = 0; k < 3; k++) vertices[y * (quadsX + 1) + x][k] = tileVertex(tile, x, y, k);
  }

  void decode() {
    const StepView first = viewOfFirstStep(block, layout);
    decodeCell(firstCell(view, block->region), FirstFields{isFirstCellRotated(view), first.word, first.cell}, corners);
    uint32_t at = view.cell + cellBytes(view.word);
    for (uint32_t g = 0; g < layout.groups; g++) {
      const uint32_t gx = g % layout.groupsX, gy = g / layout.groupsX;
      auto corner = [&](uint32_t c) { return corners[cornerOfGroup(g, c)]; };
      const CodedCell cell = cellOfGroup(view, block->region, gx, gy, at, corner(0), corner(1), corner(2), corner(3));
      FirstFields rotation = {isGroupRotated(view, g), 0, 0};
      if (rotation.isRotated) rotation = FirstFields{true, wordOfGroup(first, g), fieldsOfGroup(first, g)};
      Int3 group[cellVertices];
      decodeCell(cell, rotation, group);
      for (uint32_t j = 0; j <= uint32_t(cell.quadsY); j++)
        for (uint32_t i = 0; i <= uint32_t(cell.quadsX); i++) {
          const uint32_t vertex = vertexIndexInBlock(block->region, gx, gy, i, j);
          for (int k = 0; k < 3; k++) {
            const float onLattice = latticeCoordinate(view, k, group[5 * j + i][k]);
            vertices[vertex][k] = view.remainders == 0 ? onLattice : addRemainder(view, vertex, k, onLattice);
          }
        }
      at += cellBytes(cell.word);
    }
    if (view.remainders != 0) at = remainderOffset(view.remainders) + bytesOfRemainders(view.remainders, block->region);
    end = view.data + at;
  }

  void decodeCell(const CodedCell& cell, const FirstFields& first, Int3 out[cellVertices]) const {
    for (int j = 0; j < 5; j++) {
      const CellRow row = rowOfCell(cell, j);
      for (int i = 0; i < 5; i++) {
        Int3& vertex = out[5 * j + i];
        vertex = vertexOfRow(view.data, cell, row, i, j);
        if (first.isRotated && cellField(i, j) >= 0)
          vertex = vertex + rotateResidual(view, residualOfField(block, first.word, first.fields, cellField(i, j)));
      }
    }
  }

  /*! Vertex of the first cell that is corner c of a group. */
  uint32_t cornerOfGroup(uint32_t g, uint32_t c) const {
    return 5 * (g / layout.groupsX + (c >> 1)) + g % layout.groupsX + (c & 1);
  }

  const VertHeader* const block;
  const VertLayout layout;
  const StepView view;
  Int3 corners[cellVertices]; //!< vertices of the first cell
};
}} // namespace cvert::CVERT_ISA
