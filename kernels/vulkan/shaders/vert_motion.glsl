// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Decodes a moving cVERT block (kernels/cvert/format/motion.h) at a ray's time. The same expression, whose operations
 * round monotonically, interpolates vertices and groups' planes. Planes on world axes that bound a group's vertices at
 * two steps therefore bound them in between. The sheared axis and the block's bounds need motionSlack. */

#ifndef CBVH_VERT_MOTION_GLSL
#define CBVH_VERT_MOTION_GLSL

#include "vert_boxes.glsl"

/* The steps before and after the ray's time. */
struct CbvhSegment {
  StepView begin, end;
  float fraction; // of the time from begin to end
};

/* Coordinates of the first cell's vertices, the groups' corners, at both steps, row by row. */
ivec3 cbvhCornersAtEnds[2][cellVertices];
/* Vertices of the current group at the ray's time, row by row. */
vec3 cbvhVerticesAtTime[cellVertices];

/* Interpolates with a fixed sequence of roundings. */
float cbvhBetween(float a, float b, float fraction) {
  precise float before = 1.0 - fraction;
  precise float last = fraction * b;
  precise float between = fma(before, a, last);
  return between;
}
vec3 cbvhBetween(vec3 a, vec3 b, float fraction) {
  return vec3(cbvhBetween(a.x, b.x, fraction), cbvhBetween(a.y, b.y, fraction), cbvhBetween(a.z, b.z, fraction));
}

/* --- steps ----------------------------------------------------------------------------- */

/* Finds the segment that contains a time, and sets block.hasRaw. Returns false if the block does not exist then. */
bool cbvhFindSegment(inout CbvhVertBlock block, float time, out CbvhSegment segment) {
  VertMotion motion = motionOf(block.at);
  if (!isPresent(motion, time)) return false;
  TimeInMotion place = timeInMotion(motion, time);
  segment.fraction = clamp(place.fraction, 0.0, 1.0); // division on devices is inexact
  segment.begin = block.firstStep;
  if (place.segment > 0u) segment.begin = viewOfLaterStep(block.at, block.region, place.segment);
  segment.end = viewOfLaterStep(block.at, block.region, place.segment + 1u);
  block.hasRaw = isRaw(segment.begin.info) || isRaw(segment.end.info);
  return true;
}

/* --- vertices -------------------------------------------------------------------------- */

/* e: 0 for the beginning, 1 for the end. */
StepView cbvhEnd(CbvhSegment segment, int e) {
  StepView step_ = segment.begin;
  if (e == 1) step_ = segment.end;
  return step_;
}

/* Sets cbvhCornersAtEnds, except for raw steps. */
void cbvhDecodeCorners(CbvhVertBlock block, CbvhSegment segment) {
  [[dont_unroll]] for (int e = 0; e < 2; e++) {
    StepView step_ = cbvhEnd(segment, e);
    if (isRaw(step_.info)) continue;
    CodedCell cell = firstCell(step_, block.region);
    bool isRotated = isFirstCellRotated(step_);
    [[dont_unroll]] for (int v = 0; v < cellVertices; v++) {
      int i = v % 5, j = v / 5, field = cellField(i, j);
      ivec3 corner = vertexOfCell(step_.data, cell, i, j);
      if (isRotated && field >= 0)
        corner += rotateResidual(step_, residualOfField(block.at, block.firstStep.word, block.firstStep.cell, field));
      cbvhCornersAtEnds[e][v] = corner;
    }
  }
}

/* Sets cbvhVerticesAtTime. Requires cbvhDecodeCorners. */
void cbvhDecodeGroup(CbvhVertBlock block, CbvhSegment segment, uint gx, uint gy) {
  uint g = gy * block.groupsX + gx;
  [[dont_unroll]] for (int e = 0; e < 2; e++) {
    StepView step_ = cbvhEnd(segment, e);
    CodedCell cell = cbvhNoCell();
    bool raw = isRaw(step_.info), isRotated = !raw && isGroupRotated(step_, g);
    uint firstWord = 0u, firstFields = 0u;
    if (!raw) {
      int c = 5 * int(gy) + int(gx);
      cell = cellOfGroup(step_, block.region, gx, gy, fieldsOfGroup(step_, g), cbvhCornersAtEnds[e][c],
                         cbvhCornersAtEnds[e][c + 1], cbvhCornersAtEnds[e][c + 5], cbvhCornersAtEnds[e][c + 6]);
    }
    if (isRotated) {
      firstWord = wordOfGroup(block.firstStep, g);
      firstFields = fieldsOfGroup(block.firstStep, g);
    }
    [[dont_unroll]] for (int v = 0; v < cellVertices; v++) {
      int i = v % 5, j = v / 5, field = cellField(i, j);
      vec3 at;
      if (raw) at = cbvhRawVertex(block, step_, gx, gy, i, j);
      else {
        ivec3 vertex = vertexOfCell(step_.data, cell, i, j);
        if (isRotated && field >= 0)
          vertex += rotateResidual(step_, residualOfField(block.at, firstWord, firstFields, field));
        at = cbvhWorldVertex(block, step_, gx, gy, i, j, vertex);
      }
      if (e == 0) cbvhVerticesAtTime[v] = at;
      else cbvhVerticesAtTime[v] = cbvhBetween(cbvhVerticesAtTime[v], at, segment.fraction);
    }
  }
}

/* --- boxes, unless a step is raw ------------------------------------------------------- */

CbvhVertAxes cbvhAxesAtTime(CbvhSegment segment, CbvhPreparedRay ray, CbvhVertRay vert) {
  uint info = segment.begin.info;
  float extent = max(extentOfBounds(boundsAtBegin(segment.begin)), extentOfBounds(boundsAtEnd(segment.end, info)));
  return cbvhVertAxes(info, cbvhBetween(cbvhOrigin(segment.begin), cbvhOrigin(segment.end), segment.fraction), extent,
                      ray, vert);
}

/* Returns motionSlack per axis. On the sheared axis, errors of the three components add up. */
vec3 cbvhMotionSlack(CbvhSegment segment, CbvhVertAxes axes) {
  vec3 slack;
  float sheared = 0.0;
  for (int k = 0; k < 3; k++) {
    slack[k] = motionSlack(segment.begin.origin[k], segment.end.origin[k], axes.extent);
    sheared += abs(cbvhShearOf(axes.info, k)) * slack[k];
  }
  slack[shearedAxis(axes.info)] = sheared;
  return slack;
}

bool cbvhIntersectsBlockAtTime(CbvhSegment segment, CbvhPreparedRay ray, CbvhVertRay vert, CbvhVertAxes axes,
                               vec3 slack, float tfar) {
  ShearedBounds bounds =
      interpolateBounds(boundsAtBegin(segment.begin), boundsAtEnd(segment.end, axes.info), segment.fraction);
  return cbvhIntersectsBounds(ray, vert, axes, bounds, slack, tfar);
}

/* Tests the box of a group at the ray's time. Requires cbvhDecodeCorners. */
bool cbvhIntersectsGroupAtTime(CbvhVertBlock block, CbvhSegment segment, CbvhPreparedRay ray, CbvhVertRay vert,
                               CbvhVertAxes axes, vec3 slack, float tfar, uint gx, uint gy) {
  int c = 5 * int(gy) + int(gx), m = shearedAxis(axes.info);
  RayInterval interval = RayInterval(ray.tnear, tfar);
  [[dont_unroll]] for (int k = 0; k < 3; k++) {
    uint margins = byteAt(segment.begin.data, segment.begin.margins + uint(k) * block.groups + gy * block.groupsX + gx);
    BoxPlanes planes = BoxPlanes(0.0, 0.0);
    [[dont_unroll]] for (int e = 0; e < 2; e++) {
      BoxPlanes atEnd =
          planesOfGroup(cbvhEnd(segment, e), axes.info, cbvhCornersAtEnds[e][c], cbvhCornersAtEnds[e][c + 1],
                        cbvhCornersAtEnds[e][c + 5], cbvhCornersAtEnds[e][c + 6], margins, k);
      if (e == 0) planes = atEnd;
      else
        planes = BoxPlanes(cbvhBetween(planes.lower, atEnd.lower, segment.fraction),
                           cbvhBetween(planes.upper, atEnd.upper, segment.fraction));
    }
    if (k == m) planes = BoxPlanes(planes.lower - slack[m], planes.upper + slack[m]);
    interval = cbvhClippedByPlanes(interval, ray, vert, axes, planes, k);
  }
  return interval.from <= interval.to;
}

#endif
