// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A block of cVERT that moves as it is at a time: kernels/cvert/format/motion.h. Two steps are decoded, and what is between them
 * is interpolated, vertices and planes by the same expression, each of whose operations rounds monotonically: a plane that bounds vertices at
 * both ends bounds them between. */

#ifndef CBVH_VERT_MOTION_GLSL
#define CBVH_VERT_MOTION_GLSL

#include "vert_boxes.glsl"

/* the segment between two steps that the ray's time is in */
struct CbvhSegment
{
  CbvhVertStep begin, end;
  uint turned[2];           // of begin and end: VertStep; 0 of a first step
  float fraction;           // how far the time is from begin to end
};

/* What is decoded of a block at both ends: corners of groups, in coordinates, row by row. */
ivec3 cbvhCornersAtEnds[2][cellVertices];
/* What is decoded of a group: its vertices in the world, at the ray's time, row by row. */
vec3 cbvhVerticesNow[cellVertices];

float cbvhBetween (float a, float b, float fraction)
{
  precise float before = 1.0 - fraction;
  precise float last = fraction*b;
  precise float between = fma(before, a, last);
  return between;
}
vec3 cbvhBetween (vec3 a, vec3 b, float fraction) {
  return vec3(cbvhBetween(a.x, b.x, fraction), cbvhBetween(a.y, b.y, fraction), cbvhBetween(a.z, b.z, fraction));
}

/* --- steps ----------------------------------------------------------------------------- */

CbvhPointer cbvhBehind (CbvhPointer at, uint bytes)
{
  uint carry;
  at.address.x = uaddCarry(at.address.x, bytes, carry);
  at.address.y += carry;
  return at;
}

/* step 1 and later; steps: VertMotion */
CbvhVertStep cbvhLaterStep (CbvhVertBlock block, uint steps, uint i, out uint turned)
{
  CbvhVertStep later;
  later.at = cbvhBehind(block.at, cbvhWord(block.at, steps/4u + i - 1u));
  later.origin = vec3(cbvhFloat(later.at, 0u), cbvhFloat(later.at, 1u), cbvhFloat(later.at, 2u));
  later.boxForm = cbvhWord(later.at, 3u);
  later.word = cbvhWord(later.at, 4u);
  later.corners = 5u;
  later.spacing = cbvhReadSpacing(later);
  VertStepLayout offsets = vertStepLayout(block.region, later.boxForm);
  later.remainders = hasRemainders(later.boxForm) ? cbvhWord(later.at, offsets.remainders/4u) : 0u;
  later.margins = offsets.margins;
  later.words = offsets.words;
  later.wordsHigh = offsets.wordsHigh;
  later.cell = offsets.cell;
  later.vertices = offsets.vertices;
  turned = cbvhWord(later.at, 11u);
  return later;
}

bool cbvhIsLater (CbvhVertStep step_) { return step_.corners == 5u; }

/* False if the block is not there at the time. Sets block.hasRaw. */
bool cbvhFindSegment (inout CbvhVertBlock block, float time, out CbvhSegment segment)
{
  uint i = (vertHeaderBytes + (hasEdges(block.boxForm) || hasNumbers(block.boxForm) ? vertEdgesBytes : 0u))/4u;
  VertMotion motion = VertMotion(cbvhFloat(block.at, i), cbvhFloat(block.at, i + 1u), cbvhWord(block.at, i + 2u), cbvhWord(block.at, i + 3u));
  if (!isThere(motion, time)) return false;
  TimeInMotion place = timeInMotion(motion, time);
  segment.fraction = clamp(place.fraction, 0.0, 1.0); // divisions of devices are not exact
  segment.begin = block.first;
  segment.turned[0] = 0u;
  if (place.segment > 0u) segment.begin = cbvhLaterStep(block, motion.steps, place.segment, segment.turned[0]);
  segment.end = cbvhLaterStep(block, motion.steps, place.segment + 1u, segment.turned[1]);
  block.hasRaw = isRaw(segment.begin.boxForm) || isRaw(segment.end.boxForm);
  return true;
}

/* --- vertices -------------------------------------------------------------------------- */

/* what a step's matrix makes of a residual of the first step */
ivec3 cbvhTurned (CbvhVertStep step_, uint turned, ivec3 r)
{
  uint low = cbvhWord(step_.at, 12u), high = cbvhWord(step_.at, 13u), shift = turnShift(turned);
  return ivec3(turnedResidual(turnEntry(low, 0u), turnEntry(low, 1u), turnEntry(low, 2u), r.x, r.y, r.z, shift),
               turnedResidual(turnEntry(low, 3u), turnEntry(high, 0u), turnEntry(high, 1u), r.x, r.y, r.z, shift),
               turnedResidual(turnEntry(high, 2u), turnEntry(high, 3u), turnEntry(turned, 3u), r.x, r.y, r.z, shift));
}

/* as cbvhWordOfGroup, of groups that may have no upper bits */
uint cbvhMovingWord (CbvhVertStep step_, uint g)
{
  if (!cbvhIsLater(step_) || hasUpperBits(step_.boxForm)) return cbvhWordOfGroup(step_, g);
  uint i = step_.words + 2u*g;
  return (cbvhWord(step_.at, i >> 2) >> (8u*(i & 3u))) & 0xFFFFu;
}

uint cbvhMovingData (CbvhVertStep step_, uint g)
{
  uint data = step_.cell + cellBytes(step_.word);
  for (uint before = 0u; before < g; before++) data += cellBytes(cbvhMovingWord(step_, before));
  return data;
}

CbvhVertStep cbvhEnd (CbvhSegment segment, int e)
{
  CbvhVertStep step_ = segment.begin;
  if (e == 1) step_ = segment.end;
  return step_;
}

void cbvhDecodeCorners (CbvhVertBlock block, CbvhSegment segment)
{
  [[dont_unroll]] for (int e = 0; e < 2; e++)
  {
    CbvhVertStep step_ = cbvhEnd(segment, e);
    if (isRaw(step_.boxForm)) continue;
    CbvhCell cell = cbvhFirstCell(block, step_);
    bool turns = cbvhIsLater(step_) && isFirstCellTurned(step_.boxForm);
    [[dont_unroll]] for (int v = 0; v < cellVertices; v++)
    {
      int i = v % 5, j = v/5, field = cellField(i, j);
      ivec3 corner = cbvhCellVertex(step_.at, cell, i, j);
      if (turns && field >= 0) corner += cbvhTurned(step_, segment.turned[e], cbvhResidual(block.at, block.first.word, block.first.cell, field));
      cbvhCornersAtEnds[e][v] = corner;
    }
  }
}

/* Needs the corners. */
void cbvhDecodeGroup (CbvhVertBlock block, CbvhSegment segment, uint gx, uint gy)
{
  uint g = gy*block.groupsX + gx;
  [[dont_unroll]] for (int e = 0; e < 2; e++)
  {
    CbvhVertStep step_ = cbvhEnd(segment, e);
    CbvhCell cell = cbvhNoCell();
    bool raw = isRaw(step_.boxForm), turns = !raw && isTurned(segment.turned[e], g);
    uint firstWord = 0u, firstData = 0u;
    if (!raw) {
      int c = 5*int(gy) + int(gx);
      cell.word = cbvhMovingWord(step_, g);
      cell.data = cbvhMovingData(step_, g);
      cell.c00 = cbvhCornersAtEnds[e][c];
      cell.c10 = cbvhCornersAtEnds[e][c + 1];
      cell.c01 = cbvhCornersAtEnds[e][c + 5];
      cell.c11 = cbvhCornersAtEnds[e][c + 6];
      cell.quadsX = int(quadsOfGroup(block.quadsX, gx));
      cell.quadsY = int(quadsOfGroup(block.quadsY, gy));
    }
    if (turns) {
      firstWord = cbvhWordOfGroup(block.first, g);
      firstData = cbvhDataOfGroup(block.first, g);
    }
    [[dont_unroll]] for (int v = 0; v < cellVertices; v++)
    {
      int i = v % 5, j = v/5, field = cellField(i, j);
      vec3 at;
      if (raw) at = cbvhRawVertex(block, step_, gx, gy, i, j);
      else {
        ivec3 vertex = cbvhCellVertex(step_.at, cell, i, j);
        if (turns && field >= 0) vertex += cbvhTurned(step_, segment.turned[e], cbvhResidual(block.at, firstWord, firstData, field));
        at = cbvhWorldVertex(block, step_, gx, gy, i, j, vertex);
      }
      if (e == 0) cbvhVerticesNow[v] = at;
      else cbvhVerticesNow[v] = cbvhBetween(cbvhVerticesNow[v], at, segment.fraction);
    }
  }
}

/* --- boxes, of segments without a raw end ---------------------------------------------- */

/* The bounds of a block at an end of a segment, in the shear of the segment. */
struct CbvhEndReach
{
  uint reach, step_;
};

CbvhEndReach cbvhReachOfEnd (CbvhSegment segment, int e)
{
  if (e == 1) return CbvhEndReach(cbvhWord(segment.end.at, 15u), endReachStep(segment.turned[1]));
  uint form = segment.begin.boxForm;
  if (cbvhIsLater(segment.begin)) return CbvhEndReach(cbvhWord(segment.begin.at, 14u), beginReachStep(form));
  return CbvhEndReach(cbvhWord(segment.begin.at, 3u), reachStep(form));
}

CbvhVertAxes cbvhAxesNow (CbvhSegment segment, CbvhTravel ray, CbvhVertRay vert)
{
  uint form = segment.begin.boxForm;
  CbvhEndReach begin = cbvhReachOfEnd(segment, 0), end = cbvhReachOfEnd(segment, 1);
  float extent = max(vertExtent(form, begin.reach, begin.step_, segment.begin.spacing), vertExtent(form, end.reach, end.step_, segment.end.spacing));
  return cbvhVertAxes(form, cbvhBetween(segment.begin.origin, segment.end.origin, segment.fraction), extent, ray, vert);
}

/* What vertices and origins between the ends are rounded by, on each axis; on the sheared one three are rounded apart. */
vec3 cbvhMotionSlack (CbvhSegment segment, CbvhVertAxes axes)
{
  vec3 slack = (max(abs(segment.begin.origin), abs(segment.end.origin)) + 2.0*axes.extent)*(1.0/1048576.0);
  float sheared = 0.0;
  for (int k = 0; k < 3; k++) sheared += abs(cbvhShearOf(axes.boxForm, k))*slack[k];
  slack[shearedAxis(axes.boxForm)] = sheared;
  return slack;
}

/* whether the ray meets the bounds of a block */
bool cbvhMeetsBlockNow (CbvhSegment segment, CbvhTravel ray, CbvhVertRay vert, CbvhVertAxes axes, vec3 slack, float tfar)
{
  CbvhEndReach atBegin = cbvhReachOfEnd(segment, 0), atEnd = cbvhReachOfEnd(segment, 1);
  vec4 begin = cbvhReach(axes.boxForm, atBegin.reach, float(atBegin.step_), segment.begin.spacing);
  vec4 end = cbvhReach(axes.boxForm, atEnd.reach, float(atEnd.step_), segment.end.spacing);
  return cbvhMeetsBounds(ray, vert, axes, (1.0 - segment.fraction)*begin + segment.fraction*end, slack, tfar);
}

/* Whether the ray meets the box of a group. Needs the corners. slack: of the sheared axis is used */
bool cbvhMeetsGroupNow (CbvhVertBlock block, CbvhSegment segment, CbvhTravel ray, CbvhVertRay vert, CbvhVertAxes axes, vec3 slack, float tfar, uint gx, uint gy)
{
  int c = 5*int(gy) + int(gx), m = shearedAxis(axes.boxForm);
  float tNear = ray.tnear, tFar = tfar;
  [[dont_unroll]] for (int k = 0; k < 3; k++)
  {
    uint margins = cbvhByte(segment.begin.at, segment.begin.margins + uint(k)*block.groups + gy*block.groupsX + gx);
    vec2 planes = vec2(0.0);
    [[dont_unroll]] for (int e = 0; e < 2; e++) {
      vec2 atEnd = cbvhPlanes(axes.boxForm, cbvhEnd(segment, e), vec3(cbvhCornersAtEnds[e][c]), vec3(cbvhCornersAtEnds[e][c + 1]),
                              vec3(cbvhCornersAtEnds[e][c + 5]), vec3(cbvhCornersAtEnds[e][c + 6]), margins, k);
      if (e == 0) planes = atEnd;
      else planes = vec2(cbvhBetween(planes.x, atEnd.x, segment.fraction), cbvhBetween(planes.y, atEnd.y, segment.fraction));
    }
    if (k == m) planes += vec2(-slack[m], slack[m]);
    cbvhClipByPlanes(tNear, tFar, ray, vert, axes, planes, k);
  }
  return tNear <= tFar;
}

#endif
