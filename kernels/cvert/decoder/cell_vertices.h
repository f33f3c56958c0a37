// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Decodes single vertices of a cVERT block: residuals, coordinates, and positions in world space. Scalar code for CPUs
 * (decoded_block.h) and GPUs. */

#ifndef CVERT_DECODER_CELL_VERTICES_H
#define CVERT_DECODER_CELL_VERTICES_H

#include "../portable/int3.h"
#include "step_view.h"

CVERT_BEGIN

/*! A cell (format/cell.h) of a step that is not raw. */
struct CodedCell {
  uint32_t word;
  uint32_t fields;         //!< byte offset of the fields, relative to StepView::data
  Int3 c00, c10, c01, c11; //!< coordinates of the cell's corners
  int distance;            //!< between neighboring vertices, in quads
  int quadsX, quadsY;      //!< quads per side of the cell
};

CVERT_FUNCTION Int3 cornerOfStep(CVERT_IN(StepView) step, int c) {
  return Int3(cornerCoordinate(cornerWord(step, cornerPair(c, 0)), c, 0),
              cornerCoordinate(cornerWord(step, cornerPair(c, 1)), c, 1),
              cornerCoordinate(cornerWord(step, cornerPair(c, 2)), c, 2));
}

CVERT_FUNCTION CodedCell firstCell(CVERT_IN(StepView) step, uint32_t region) {
  CodedCell cell;
  cell.word = step.word;
  cell.fields = step.cell;
  cell.c00 = cornerOfStep(step, 0);
  cell.c10 = cornerOfStep(step, 1);
  cell.c01 = cornerOfStep(step, 2);
  cell.c11 = cornerOfStep(step, 3);
  cell.distance = int(groupQuads);
  cell.quadsX = int(vertQuadsX(region));
  cell.quadsY = int(vertQuadsY(region));
  return cell;
}

/*! c00 to c11: coordinates of the group's corners, which are vertices of the first cell. fields: fieldsOfGroup. */
CVERT_FUNCTION CodedCell cellOfGroup(CVERT_IN(StepView) step, uint32_t region, uint32_t gx, uint32_t gy,
                                     uint32_t fields, Int3 c00, Int3 c10, Int3 c01, Int3 c11) {
  CodedCell cell;
  cell.word = wordOfGroup(step, gy * groupsOf(vertQuadsX(region)) + gx);
  cell.fields = fields;
  cell.c00 = c00;
  cell.c10 = c10;
  cell.c01 = c01;
  cell.c11 = c11;
  cell.distance = 1;
  cell.quadsX = int(quadsOfGroup(vertQuadsX(region), gx));
  cell.quadsY = int(quadsOfGroup(vertQuadsY(region), gy));
  return cell;
}

/* --- residuals ------------------------------------------------------------------------- */

CVERT_FUNCTION int componentOfResidual(CVERT_POINTER(void) data, uint32_t bit, int bits) {
  return bits == 0 ? 0 : cellResidual(bitsAt(data, bit, uint32_t(bits)), 0, bits);
}

/*! Decodes a residual: x, y and z. word, fields: as in CodedCell. */
CVERT_FUNCTION Int3 residualOfField(CVERT_POINTER(void) data, uint32_t word, uint32_t fields, int field) {
  int bits0 = cellBits(word, 0), bits1 = cellBits(word, 1), bits2 = cellBits(word, 2), bits = bits0 + bits1 + bits2;
  uint32_t begin = 8u * fields;
  int r0, r1, r2;
  if (isByAxis(word)) {
    r0 = componentOfResidual(data, begin + uint32_t(field * bits0), bits0);
    r1 = componentOfResidual(data, begin + uint32_t(cellFields * bits0 + field * bits1), bits1);
    r2 = componentOfResidual(data, begin + uint32_t(cellFields * (bits0 + bits1) + field * bits2), bits2);
  } else {
    uint32_t residuals = bits == 0 ? 0u : bitsAt(data, begin + uint32_t(field * bits), uint32_t(bits));
    r0 = cellResidual(residuals, 0, bits0);
    r1 = cellResidual(residuals, bits0, bits1);
    r2 = cellResidual(residuals, bits0 + bits1, bits2);
  }
  r1 += slopeResidual(cellSlope(word, 1), r0);
  r2 += slopeResidual(cellSlope(word, 2), r0);
  int axis = cellMainAxis(word);
  return axis == 0 ? Int3(r0, r1, r2) : axis == 1 ? Int3(r2, r0, r1) : Int3(r1, r2, r0);
}

/*! Applies the step's matrix to a residual of the first step. */
CVERT_FUNCTION Int3 rotateResidual(CVERT_IN(StepView) step, Int3 r) {
  uint32_t a = CVERT_AT(VertStep, step.data).matrix[0], b = CVERT_AT(VertStep, step.data).matrix[1];
  uint32_t shift = rotationShift(step.rotation);
  return Int3(rotatedResidual(rotationEntry(a, 0u), rotationEntry(a, 1u), rotationEntry(a, 2u), r.x, r.y, r.z, shift),
              rotatedResidual(rotationEntry(a, 3u), rotationEntry(b, 0u), rotationEntry(b, 1u), r.x, r.y, r.z, shift),
              rotatedResidual(rotationEntry(b, 2u), rotationEntry(b, 3u), rotationEntry(step.rotation, 3u), r.x, r.y,
                              r.z, shift));
}

/* --- coordinates ----------------------------------------------------------------------- */

/*! Predictions of a row: (start + weight*slope) >> 8 equals cellPrediction, with fewer operations. */
struct CellRow {
  Int3 start, slope;
};

CVERT_FUNCTION int weightInCell(int i, int distance, int quads) {
  return quads == 4 * distance ? 4 * i : cellWeight(i, distance, quads);
}

CVERT_FUNCTION CellRow rowOfCell(CVERT_IN(CodedCell) cell, int j) {
  int weight = weightInCell(j, cell.distance, cell.quadsY);
  CellRow row;
  row.start = 256 * cell.c00 + 16 * weight * (cell.c01 - cell.c00) + 128;
  row.slope = 16 * (cell.c10 - cell.c00) + weight * (cell.c11 - cell.c10 - cell.c01 + cell.c00);
  return row;
}

/*! Coordinates of vertex i of row j. Does not add a rotated residual. data: StepView::data. */
CVERT_FUNCTION Int3 vertexOfRow(CVERT_POINTER(void) data, CVERT_IN(CodedCell) cell, CVERT_IN(CellRow) row, int i,
                                int j) {
  Int3 vertex = (row.start + weightInCell(i, cell.distance, cell.quadsX) * row.slope) >> 8;
  int field = cellField(i, j);
  if (field >= 0) vertex = vertex + residualOfField(data, cell.word, cell.fields, field);
  return vertex;
}

CVERT_FUNCTION Int3 vertexOfCell(CVERT_POINTER(void) data, CVERT_IN(CodedCell) cell, int i, int j) {
  return vertexOfRow(data, cell, rowOfCell(cell, j), i, j);
}

/* --- the world ------------------------------------------------------------------------- */

/*! Index in the block, row by row, of vertex i, j (0 to 4) of a group. Groups with fewer quads repeat their last
 *  vertices. */
CVERT_FUNCTION uint32_t vertexIndexInBlock(uint32_t region, uint32_t gx, uint32_t gy, uint32_t i, uint32_t j) {
  uint32_t quadsX = vertQuadsX(region), quadsY = vertQuadsY(region), x = groupQuads * gx + i, y = groupQuads * gy + j;
  return (y < quadsY ? y : quadsY) * (quadsX + 1u) + (x < quadsX ? x : quadsX);
}

/*! World coordinate without remainder. Requires a step that is not raw. The sum is exact, see format/block.h. */
CVERT_FUNCTION float latticeCoordinate(CVERT_IN(StepView) step, int axis, int coordinate) {
  CVERT_PRECISE float at = step.origin[axis] + float(coordinate) * step.spacing.at[axis];
  return at;
}

/*! Adds a remainder to a world coordinate. Requires a step with remainders. lattice: latticeCoordinate. vertex:
 *  vertexIndexInBlock. */
CVERT_FUNCTION float addRemainder(CVERT_IN(StepView) step, uint32_t vertex, int axis, float lattice) {
  uint32_t bits = remainderBits(step.remainders, axis);
  if (bits == 0u) return lattice;
  uint32_t word =
      bitsAt(step.data, remainderBegin(step.remainders, vertex, axis), storedRemainderBits(step.remainders, axis));
  return addRemainder(lattice, word, bits, step.spacing.at[axis]);
}

/*! Requires a raw step. */
CVERT_FUNCTION float rawCoordinate(CVERT_IN(StepView) step, uint32_t vertex, int axis) {
  return floatAt(step.data, step.vertices / 4u + 3u * vertex + uint32_t(axis));
}

CVERT_END

#endif
