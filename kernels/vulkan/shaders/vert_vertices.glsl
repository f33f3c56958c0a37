// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Vertices of a block of cVERT at a time step: kernels/cvert/format/block.h, cell.h and motion.h say what the bytes are. A block that does not
 * move has one step. */

#ifndef CBVH_VERT_VERTICES_GLSL
#define CBVH_VERT_VERTICES_GLSL

#include "memory.glsl"
#include "../../cvert/format/motion.h"

struct CbvhVertStep
{
  CbvhPointer at;                       // where it begins
  vec3 origin;
  VertSpacing spacing;
  uint remainders;                      // their word; 0 if there are none
  uint boxForm, word;
  uint corners;                         // word of its first corner
  uint margins, words, wordsHigh, cell; // bytes from where it begins
  uint vertices;                        // of a raw step
};

struct CbvhVertBlock
{
  CbvhPointer at;
  uint reach, region, boxForm;
  uint groupsX, groupsY, groups, quadsX, quadsY;
  CbvhVertStep first;                   // step 0
  bool hasRaw;                          // a step that the ray sees is raw
};

VertSpacing cbvhReadSpacing (CbvhVertStep step_)
{
  uint i = step_.corners;
  return vertSpacing(step_.word, cbvhWord(step_.at, i), cbvhWord(step_.at, i + 1u), cbvhWord(step_.at, i + 2u), cbvhWord(step_.at, i + 3u));
}

vec3 cbvhSpacing (CbvhVertStep step_) { return vec3(step_.spacing.at[0], step_.spacing.at[1], step_.spacing.at[2]); }

CbvhVertStep cbvhFirstStep (CbvhPointer at, vec3 origin, uint region, uint boxForm)
{
  VertLayout offsets = vertLayout(region, boxForm);
  CbvhVertStep first;
  first.at = at;
  first.origin = origin;
  first.boxForm = boxForm;
  first.word = cbvhWord(at, 15u);
  first.corners = 8u;
  first.spacing = cbvhReadSpacing(first);
  first.remainders = hasRemainders(boxForm) ? cbvhWord(at, offsets.remainders/4u) : 0u;
  first.margins = offsets.margins;
  first.words = offsets.words;
  first.wordsHigh = offsets.wordsHigh;
  first.cell = offsets.cell;
  first.vertices = offsets.vertices;
  return first;
}

CbvhVertBlock cbvhReadVertBlock (CbvhPointer at)
{
  uvec4 head = cbvhQuadword(at, 0u);
  CbvhVertBlock block;
  block.at = at;
  block.reach = head.w;
  block.region = cbvhWord(at, 6u);
  block.boxForm = cbvhWord(at, 14u);
  block.quadsX = vertQuadsX(block.region);
  block.quadsY = vertQuadsY(block.region);
  block.groupsX = groupsOf(block.quadsX);
  block.groupsY = groupsOf(block.quadsY);
  block.groups = block.groupsX*block.groupsY;
  block.first = cbvhFirstStep(at, uintBitsToFloat(head.xyz), block.region, block.boxForm);
  block.hasRaw = isRaw(block.boxForm);
  return block;
}

/* --- cells ----------------------------------------------------------------------------- */

/* A cell that is being decoded: its corners, and where its fields are. */
struct CbvhCell
{
  uint word;
  uint data;                   // byte of the first field
  ivec3 c00, c10, c01, c11;
  int step, quadsX, quadsY;
};

int cbvhWeight (int i, int step_, int quads) { return quads == 4*step_ ? 4*i : cellWeight(i, step_, quads); }

int cbvhComponent (CbvhPointer at, uint bit, int bits) { return bits == 0 ? 0 : cellResidual(cbvhBits(at, bit), 0, bits); }

/* residual in a field of a cell; data: byte of its first field */
ivec3 cbvhResidual (CbvhPointer at, uint word, uint data, int field)
{
  int bits0 = cellBits(word, 0), bits1 = cellBits(word, 1), bits2 = cellBits(word, 2), bits = bits0 + bits1 + bits2;
  int r0, r1, r2;
  if (isByAxis(word)) {
    uint start = 8u*data;
    r0 = cbvhComponent(at, start + uint(field*bits0), bits0);
    r1 = cbvhComponent(at, start + uint(cellFields*bits0 + field*bits1), bits1);
    r2 = cbvhComponent(at, start + uint(cellFields*(bits0 + bits1) + field*bits2), bits2);
  }
  else {
    uint residuals = bits == 0 ? 0u : cbvhBits(at, 8u*data + uint(field*bits));
    r0 = cellResidual(residuals, 0, bits0);
    r1 = cellResidual(residuals, bits0, bits1);
    r2 = cellResidual(residuals, bits0 + bits1, bits2);
  }
  r1 += slopeResidual(cellSlope(word, 1), r0);
  r2 += slopeResidual(cellSlope(word, 2), r0);
  int axis = cellMainAxis(word);
  return axis == 0 ? ivec3(r0, r1, r2) : axis == 1 ? ivec3(r2, r0, r1) : ivec3(r1, r2, r0);
}

/* Predictions of a row: (start + weight*slope) >> 8, which is cellPrediction of cell.h. */
struct CbvhRow
{
  ivec3 start, slope;
};

CbvhRow cbvhRow (CbvhCell cell, int j)
{
  int weightY = cbvhWeight(j, cell.step, cell.quadsY);
  CbvhRow row;
  row.start = 256*cell.c00 + 16*weightY*(cell.c01 - cell.c00) + 128;
  row.slope = 16*(cell.c10 - cell.c00) + weightY*(cell.c11 - cell.c10 - cell.c01 + cell.c00);
  return row;
}

/* coordinates of vertex i, j */
ivec3 cbvhRowVertex (CbvhPointer at, CbvhCell cell, CbvhRow row, int i, int j)
{
  ivec3 vertex = (row.start + cbvhWeight(i, cell.step, cell.quadsX)*row.slope) >> 8;
  int field = cellField(i, j);
  return field < 0 ? vertex : vertex + cbvhResidual(at, cell.word, cell.data, field);
}

ivec3 cbvhCellVertex (CbvhPointer at, CbvhCell cell, int i, int j) { return cbvhRowVertex(at, cell, cbvhRow(cell, j), i, j); }

ivec3 cbvhCorner (CbvhVertStep step_, int c)
{
  ivec3 corner;
  for (int k = 0; k < 3; k++) corner[k] = cornerCoordinate(cbvhWord(step_.at, step_.corners + uint(cornerPair(c, k))), c, k);
  return corner;
}

CbvhCell cbvhNoCell ()
{
  CbvhCell cell;
  cell.word = cell.data = 0u;
  cell.c00 = cell.c10 = cell.c01 = cell.c11 = ivec3(0);
  cell.step = cell.quadsX = cell.quadsY = 1;
  return cell;
}

/* the cell of the corners of groups, of a step that is not raw */
CbvhCell cbvhFirstCell (CbvhVertBlock block, CbvhVertStep step_)
{
  CbvhCell cell;
  cell.word = step_.word;
  cell.data = step_.cell;
  cell.c00 = cbvhCorner(step_, 0);
  cell.c10 = cbvhCorner(step_, 1);
  cell.c01 = cbvhCorner(step_, 2);
  cell.c11 = cbvhCorner(step_, 3);
  cell.step = int(groupQuads);
  cell.quadsX = int(block.quadsX);
  cell.quadsY = int(block.quadsY);
  return cell;
}

uint cbvhWordOfGroup (CbvhVertStep step_, uint g)
{
  uint low = cbvhWord(step_.at, (step_.words + 2u*g) >> 2) >> (8u*((step_.words + 2u*g) & 3u)); // at even bytes
  return (low & 0xFFFFu) | (cbvhByte(step_.at, step_.wordsHigh + g) << 16);
}

/* byte of the first field of a group's cell */
uint cbvhDataOfGroup (CbvhVertStep step_, uint g)
{
  uint data = step_.cell + cellBytes(step_.word);
  for (uint before = 0u; before < g; before++) data += cellBytes(cbvhWordOfGroup(step_, before));
  return data;
}

/* first: the cell of the corners of groups */
CbvhCell cbvhGroupCell (CbvhVertBlock block, CbvhCell first, uint gx, uint gy)
{
  uint g = gy*block.groupsX + gx;
  CbvhCell cell;
  cell.data = cbvhDataOfGroup(block.first, g);
  cell.word = cbvhWordOfGroup(block.first, g);
  cell.c00 = cbvhCellVertex(block.at, first, int(gx), int(gy));
  cell.c10 = cbvhCellVertex(block.at, first, int(gx) + 1, int(gy));
  cell.c01 = cbvhCellVertex(block.at, first, int(gx), int(gy) + 1);
  cell.c11 = cbvhCellVertex(block.at, first, int(gx) + 1, int(gy) + 1);
  cell.step = 1;
  cell.quadsX = int(quadsOfGroup(block.quadsX, gx));
  cell.quadsY = int(quadsOfGroup(block.quadsY, gy));
  return cell;
}

/* Vertex i, j of group gx, gy of a step that is not raw in the world, from its coordinates. Both sums are exact: format.h */
vec3 cbvhWorldVertex (CbvhVertBlock block, CbvhVertStep step_, uint gx, uint gy, int i, int j, ivec3 coordinates)
{
  precise vec3 at = step_.origin + vec3(coordinates)*cbvhSpacing(step_);
  if (step_.remainders == 0u) return at;
  uint x = min(groupQuads*gx + uint(i), block.quadsX), y = min(groupQuads*gy + uint(j), block.quadsY);
  for (int k = 0; k < 3; k++) {
    uint bits = remainderBits(step_.remainders, k);
    if (bits == 0u) continue;
    at[k] = withRemainder(at[k], cbvhBits(step_.at, remainderBegin(step_.remainders, y*(block.quadsX + 1u) + x, k)), bits, step_.spacing.at[k]);
  }
  return at;
}

/* vertex i, j of group gx, gy of a raw step in the world */
vec3 cbvhRawVertex (CbvhVertBlock block, CbvhVertStep step_, uint gx, uint gy, int i, int j)
{
  uint x = min(groupQuads*gx + uint(i), block.quadsX), y = min(groupQuads*gy + uint(j), block.quadsY);
  uint first = step_.vertices/4u + 3u*(y*(block.quadsX + 1u) + x);
  return vec3(cbvhFloat(step_.at, first), cbvhFloat(step_.at, first + 1u), cbvhFloat(step_.at, first + 2u));
}

#endif
