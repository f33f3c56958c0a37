// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Decodes vertices of a cVERT block at a time step with kernels/cvert/decoder. A static block has one step. */

#ifndef CBVH_VERT_VERTICES_GLSL
#define CBVH_VERT_VERTICES_GLSL

#include "memory.glsl"
#include "../../cvert/decoder/cell_vertices.h"

struct CbvhVertBlock {
  uvec2 at; // address
  uint geomID;
  uint region, info;
  uint groupsX, groupsY, groups, quadsX, quadsY;
  StepView firstStep;
  bool hasRaw; // a step at the ray's time is raw; moving blocks: set by cbvhFindSegment
};

CbvhVertBlock cbvhReadVertBlock(CbvhPointer at) {
  CbvhVertBlock block;
  block.at = at.address;
  block.geomID = at.geomID;
  block.region = CVERT_AT(VertHeader, block.at).region;
  block.info = CVERT_AT(VertHeader, block.at).info;
  block.quadsX = vertQuadsX(block.region);
  block.quadsY = vertQuadsY(block.region);
  VertLayout offsets = vertLayout(block.region, block.info);
  block.groupsX = offsets.groupsX;
  block.groupsY = offsets.groupsY;
  block.groups = offsets.groups;
  block.firstStep = viewOfFirstStep(block.at, offsets);
  block.hasRaw = isRaw(block.info);
  return block;
}

vec3 cbvhOrigin(StepView step_) { return vec3(step_.origin[0], step_.origin[1], step_.origin[2]); }
vec3 cbvhSpacing(StepView step_) { return vec3(step_.spacing.at[0], step_.spacing.at[1], step_.spacing.at[2]); }

/* Placeholder for raw and moving blocks, whose vertices do not come from this cell. */
CodedCell cbvhNoCell() {
  CodedCell cell;
  cell.word = cell.fields = 0u;
  cell.c00 = cell.c10 = cell.c01 = cell.c11 = ivec3(0);
  cell.distance = cell.quadsX = cell.quadsY = 1;
  return cell;
}

/* The cell of a group at the first step. first: the first cell, whose vertices are the groups' corners. */
CodedCell cbvhGroupCell(CbvhVertBlock block, CodedCell first, uint gx, uint gy) {
  int i = int(gx), j = int(gy);
  return cellOfGroup(block.firstStep, block.region, gx, gy, fieldsOfGroup(block.firstStep, gy * block.groupsX + gx),
                     vertexOfCell(block.at, first, i, j), vertexOfCell(block.at, first, i + 1, j),
                     vertexOfCell(block.at, first, i, j + 1), vertexOfCell(block.at, first, i + 1, j + 1));
}

/* World position of a vertex from its coordinates. Requires a step that is not raw. */
vec3 cbvhWorldVertex(CbvhVertBlock block, StepView step_, uint gx, uint gy, int i, int j, ivec3 coordinates) {
  vec3 at = vec3(latticeCoordinate(step_, 0, coordinates.x), latticeCoordinate(step_, 1, coordinates.y),
                 latticeCoordinate(step_, 2, coordinates.z));
  if (step_.remainders == 0u) return at;
  uint vertex = vertexIndexInBlock(block.region, gx, gy, uint(i), uint(j));
  for (int k = 0; k < 3; k++) at[k] = addRemainder(step_, vertex, k, at[k]);
  return at;
}

/* World position of a vertex of a raw step. */
vec3 cbvhRawVertex(CbvhVertBlock block, StepView step_, uint gx, uint gy, int i, int j) {
  uint vertex = vertexIndexInBlock(block.region, gx, gy, uint(i), uint(j));
  return vec3(rawCoordinate(step_, vertex, 0), rawCoordinate(step_, vertex, 1), rawCoordinate(step_, vertex, 2));
}

#endif
