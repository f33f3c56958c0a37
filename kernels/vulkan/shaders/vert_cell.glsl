// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Vertices of a cell of a block that does not move, in order. Each word of a cell is loaded once, as part of a
 * quadword. Loops over vertices are not unrolled: instruction caches of GPUs hold only a few thousand instructions. */

#ifndef CBVH_VERT_CELL_GLSL
#define CBVH_VERT_CELL_GLSL

#include "vert_vertices.glsl"

const int cellColumns = 5;

/* Components along the axes m, m+1 and m+2, counted round. */
vec3 cbvhFromAxis (int m, vec3 v) { return m == 0 ? v : m == 1 ? v.yzx : v.zxy; }
ivec3 cbvhFromAxis (int m, ivec3 v) { return m == 0 ? v : m == 1 ? v.yzx : v.zxy; }

/* Fields of a cell in order. */
struct CbvhFields
{
  uvec2 at;          // the block
  uint bit;          // of the next field, from the block's start
  uint last;         // number of the quadword in which the cell ends
  uvec4 now, after;  // the quadword with that bit, and the one after it
};

CbvhFields cbvhFieldsOf (uvec2 at, CodedCell cell)
{
  CbvhFields fields;
  fields.at = at;
  fields.bit = 8u*cell.fields;
  fields.last = (fields.bit + uint(cellFields*cellFieldBits(cell.word)) - 1u) >> 7;
  uint i = fields.bit >> 7;
  fields.now = CbvhQuadwords(at).at[min(i, fields.last)];
  fields.after = CbvhQuadwords(at).at[min(i + 1u, fields.last)];
  return fields;
}

/* Returns the next field, of up to 32 bits; those above it may have any value. */
uint cbvhNextField (inout CbvhFields fields, uint bits)
{
  uint i = (fields.bit >> 5) & 3u, shift = fields.bit & 31u;
  uint low = i == 0u ? fields.now.x : i == 1u ? fields.now.y : i == 2u ? fields.now.z : fields.now.w;
  uint high = i == 0u ? fields.now.y : i == 1u ? fields.now.z : i == 2u ? fields.now.w : fields.after.x;
  uint end = fields.bit + bits;
  if ((end >> 7) != (fields.bit >> 7)) {
    fields.now = fields.after;
    fields.after = CbvhQuadwords(fields.at).at[min((end >> 7) + 1u, fields.last)];
  }
  fields.bit = end;
  return (low >> shift) | ((high << 1) << (31u - shift));
}

/* A cell that is decoded row by row, in coordinates along the axes m, m+1 and m+2. */
struct CbvhCellReader
{
  CodedCell cell;    // corners along these axes
  int m;
  CbvhFields fields;
  CellRow row;
};

CbvhCellReader cbvhReader (uvec2 at, CodedCell cell, int m)
{
  CbvhCellReader reader;
  reader.cell = cell;
  reader.cell.c00 = cbvhFromAxis(m, cell.c00);
  reader.cell.c10 = cbvhFromAxis(m, cell.c10);
  reader.cell.c01 = cbvhFromAxis(m, cell.c01);
  reader.cell.c11 = cbvhFromAxis(m, cell.c11);
  reader.m = m;
  reader.fields = cbvhFieldsOf(at, cell);
  reader.row = CellRow(ivec3(0), ivec3(0));
  return reader;
}

/* Returns a residual of a cell whose residuals come axis by axis: along the main axis and the next two, without
 * slopes. */
ivec3 cbvhResidualByAxis (uvec2 at, CodedCell cell, int field)
{
  ivec3 r = ivec3(0);
  uint begin = 8u*cell.fields;
  [[dont_unroll]] for (int k = 0; k < 3; k++) {
    int bits = cellBits(cell.word, k);
    r = ivec3(r.yz, componentOfResidual(at, begin + uint(field*bits), bits));
    begin += uint(cellFields*bits);
  }
  return r;
}

/* Returns the coordinates of vertex i of row j. All vertices have to be read, row by row. */
ivec3 cbvhNextVertex (inout CbvhCellReader reader, int i, int j)
{
  if (i == 0) reader.row = rowOfCell(reader.cell, j);
  ivec3 vertex = (reader.row.start + weightInCell(i, reader.cell.distance, reader.cell.quadsX)*reader.row.slope) >> 8;
  int field = cellField(i, j);
  if (field < 0) return vertex;
  uint word = reader.cell.word;
  ivec3 r;
  if (isByAxis(word)) r = cbvhResidualByAxis(reader.fields.at, reader.cell, field);
  else {
    int bits0 = cellBits(word, 0), bits1 = cellBits(word, 1), bits2 = cellBits(word, 2);
    int residuals = int(cbvhNextField(reader.fields, uint(bits0 + bits1 + bits2)));
    r.x = bitfieldExtract(residuals, 0, bits0);
    r.y = bitfieldExtract(residuals, bits0, bits1);
    r.z = bitfieldExtract(residuals, bits0 + bits1, bits2);
  }
  r.y += slopeResidual(cellSlope(word, 1), r.x);
  r.z += slopeResidual(cellSlope(word, 2), r.x);
  int turn = reader.m - cellMainAxis(word);
  return vertex + cbvhFromAxis(turn < 0 ? turn + 3 : turn, r);
}

/* The cell whose vertices are the corners of groups, by the header's words of corners. */
CodedCell cbvhFirstCell (CbvhVertBlock block, uvec4 header[4])
{
  uvec4 a = header[2];
  uvec2 b = header[3].xy;
  CodedCell cell;
  cell.word = block.first.word;
  cell.fields = block.first.cell;
  cell.c00 = ivec3(a.x, a.x >> 16, a.y) & 16383;
  cell.c10 = ivec3(a.y >> 16, a.z, a.z >> 16) & 16383;
  cell.c01 = ivec3(a.w, a.w >> 16, b.x) & 16383;
  cell.c11 = ivec3(b.x >> 16, b.y, b.y >> 16) & 16383;
  cell.distance = int(groupQuads);
  cell.quadsX = int(block.quadsX);
  cell.quadsY = int(block.quadsY);
  return cell;
}

/* As fieldsOfGroup, two groups at a time: numbers of bits are in the lower 12 bits of a group's 16. */
uint cbvhFieldsOfGroup (CbvhVertBlock block, uint g)
{
  uint begin = block.first.words >> 1, end = begin + g, sums = 0u;
  for (uint i = begin; i < end; i = (i | 1u) + 1u)
  {
    uint words = wordAt(block.at, i >> 1);
    if ((i & 1u) != 0u) words &= 0xFFFF0000u;
    if ((i | 1u) >= end) words &= 0xFFFFu;
    uint bits = (words & 0x000F000Fu) + ((words >> 4) & 0x000F000Fu) + ((words >> 8) & 0x000F000Fu);
    sums += ((uint(cellFields)*bits + 0x00070007u) >> 3) & 0x00FF00FFu;
  }
  return block.first.cell + cellBytes(block.first.word) + (sums & 0xFFFFu) + (sums >> 16);
}

/* first: the cell of the corners of groups */
CodedCell cbvhGroupCell (CbvhVertBlock block, CodedCell first, uint gx, uint gy)
{
  ivec3 c00, c10, c01, c11;
  [[dont_unroll]] for (int c = 0; c < 4; c++) {
    c00 = c10;
    c10 = c01;
    c01 = c11;
    c11 = vertexOfCell(block.at, first, int(gx) + (c & 1), int(gy) + (c >> 1));
  }
  uint fields = cbvhFieldsOfGroup(block, gy*block.groupsX + gx);
  return cellOfGroup(block.first, block.region, gx, gy, fields, c00, c10, c01, c11);
}

#endif
