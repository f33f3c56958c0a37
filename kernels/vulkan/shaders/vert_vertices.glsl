// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Vertices of a block of cVERT at a time step, by the codec's own decoder: kernels/cvert/decoder. A block that does
 * not move has one step. */

#ifndef CBVH_VERT_VERTICES_GLSL
#define CBVH_VERT_VERTICES_GLSL

#include "memory.glsl"
#include "../../cvert/decoder/cell_vertices.h"

struct CbvhVertBlock
{
  uvec2 at;
  uint geomID;
  uint region, boxForm;
  uint groupsX, groupsY, groups, quadsX, quadsY;
  StepView first;                       // step 0
  bool hasRaw;                          // a step that the ray sees is raw
};

/* By the quadwords of the header, which are read at once. */
CbvhVertBlock cbvhReadVertBlock (CbvhPointer at, uvec4 header[4])
{
  CbvhVertBlock block;
  block.at = at.address;
  block.geomID = at.geomID;
  block.region = header[1].z;
  block.boxForm = header[3].z;
  block.quadsX = vertQuadsX(block.region);
  block.quadsY = vertQuadsY(block.region);
  VertLayout offsets = vertLayout(block.region, block.boxForm);
  block.groupsX = offsets.groupsX;
  block.groupsY = offsets.groupsY;
  block.groups = offsets.groups;
  StepView first;
  first.data = block.at;
  first.isLater = false;
  vec3 origin = uintBitsToFloat(header[0].xyz);
  first.origin[0] = origin.x;
  first.origin[1] = origin.y;
  first.origin[2] = origin.z;
  first.spacing = vertSpacing(header[3].w, header[2].x, header[2].y, header[2].z, header[2].w);
  first.form = block.boxForm;
  first.word = header[3].w;
  first.turned = 0u;
  first.remainders = hasRemainders(block.boxForm) ? cbvhWord(at, offsets.remainders/4u) : 0u;
  first.hasHigh = true;
  first.corners = vertCornersOffset;
  first.margins = offsets.margins;
  first.words = offsets.words;
  first.wordsHigh = offsets.wordsHigh;
  first.cell = offsets.cell;
  first.vertices = offsets.vertices;
  block.first = first;
  block.hasRaw = isRaw(block.boxForm);
  return block;
}

vec3 cbvhOrigin (StepView step_) { return vec3(step_.origin[0], step_.origin[1], step_.origin[2]); }
vec3 cbvhSpacing (StepView step_) { return vec3(step_.spacing.at[0], step_.spacing.at[1], step_.spacing.at[2]); }

CodedCell cbvhNoCell ()
{
  CodedCell cell;
  cell.word = cell.fields = 0u;
  cell.c00 = cell.c10 = cell.c01 = cell.c11 = ivec3(0);
  cell.distance = cell.quadsX = cell.quadsY = 1;
  return cell;
}

/* Vertex i, j of group gx, gy of a step that is not raw in the world, from its coordinates. */
vec3 cbvhWorldVertex (CbvhVertBlock block, StepView step_, uint gx, uint gy, int i, int j, ivec3 coordinates)
{
  vec3 at = vec3(latticeVertex(step_, 0, coordinates.x), latticeVertex(step_, 1, coordinates.y),
                 latticeVertex(step_, 2, coordinates.z));
  if (step_.remainders == 0u) return at;
  uint vertex = vertexOfGroup(block.region, gx, gy, uint(i), uint(j));
  for (int k = 0; k < 3; k++) at[k] = withRemainder(step_, vertex, k, at[k]);
  return at;
}

/* vertex i, j of group gx, gy of a raw step in the world */
vec3 cbvhRawVertex (CbvhVertBlock block, StepView step_, uint gx, uint gy, int i, int j)
{
  uint vertex = vertexOfGroup(block.region, gx, gy, uint(i), uint(j));
  return vec3(rawVertex(step_, vertex, 0), rawVertex(step_, vertex, 1), rawVertex(step_, vertex, 2));
}

#endif
