// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Tests a ray against a cVERT block's bounds and its groups' boxes, conservatively: planes are exact or interpolated
 * between exact ones, and widened by the slacks of kernels/cvert/rule/rule.h. */

#ifndef CBVH_VERT_BOXES_GLSL
#define CBVH_VERT_BOXES_GLSL

#include "ray.glsl"
#include "vert_vertices.glsl"
#include "../../cvert/decoder/group_planes.h"
#include "../../cvert/rule/rule.h"

struct CbvhVertRay {
  vec3 rcp;      // reciprocals of the direction, finite
  float largest; // largest component of the direction, absolute
};

CbvhVertRay cbvhVertRay(CbvhPreparedRay ray) {
  CbvhVertRay vert;
  vec3 size = abs(ray.dir);
  vert.largest = max(size.x, max(size.y, size.z));
  for (int k = 0; k < 3; k++) vert.rcp[k] = directionReciprocal(ray.dir[k], vert.largest);
  return vert;
}

/* Axes of the boxes of a block that is not raw, and the ray's sheared coordinate, relative to the block's origin. */
struct CbvhVertAxes {
  uint info;
  vec3 origin;
  float extent;          // extentOfBounds
  float org, rcp, error; // of the sheared ray; error: shearedSlack
};

/* Factor of world axis k in the sheared coordinate. */
float cbvhShearOf(uint info, int k) {
  int m = shearedAxis(info);
  return worldShear(info, k >= m ? k - m : k - m + 3);
}

CbvhVertAxes cbvhVertAxes(uint info, vec3 origin, float extent, CbvhPreparedRay ray, CbvhVertRay vert) {
  ShearedCoordinate along = zeroShearedCoordinate();
  for (int k = 0; k < 3; k++)
    along = addSheared(along, ray.org[k], ray.dir[k], origin[k], extent, cbvhShearOf(info, k));
  return CbvhVertAxes(info, origin, extent, along.org, directionReciprocal(along.dir, vert.largest),
                      shearedSlack(along.size));
}

float cbvhSlack(CbvhVertAxes axes, CbvhPreparedRay ray, int k) {
  return boxSlack(ray.org[k], axes.origin[k], axes.extent);
}

/* Returns false if the ray misses the bounds of a block, widened by `slack` on each axis. */
bool cbvhIntersectsBounds(CbvhPreparedRay ray, CbvhVertRay vert, CbvhVertAxes axes, ShearedBounds bounds, vec3 slack,
                          float tfar) {
  int m = shearedAxis(axes.info);
  RayInterval interval = RayInterval(ray.tnear, tfar);
  for (int i = 0; i < 2; i++) {
    int k = axisAfter(m, 1 + i);
    float from = axes.origin[k] - ray.org[k], wide = cbvhSlack(axes, ray, k) + slack[k];
    interval = clipInterval(interval, from - wide, (from + bounds.upper[i]) + wide, vert.rcp[k]);
  }
  float wide = axes.error + slack[m];
  interval =
      clipInterval(interval, (bounds.sheared[0] - axes.org) - wide, (bounds.sheared[1] - axes.org) + wide, axes.rcp);
  return interval.from <= interval.to;
}

/* Clips the ray by a group's planes on axis k. */
RayInterval cbvhClippedByPlanes(RayInterval interval, CbvhPreparedRay ray, CbvhVertRay vert, CbvhVertAxes axes,
                                BoxPlanes planes, int k) {
  bool isSheared = k == shearedAxis(axes.info);
  float from = isSheared ? axes.org : ray.org[k], error = isSheared ? axes.error : cbvhSlack(axes, ray, k);
  return clipInterval(interval, (planes.lower - from) - error, (planes.upper - from) + error,
                      isSheared ? axes.rcp : vert.rcp[k]);
}

/* Tests the box of group g of a static block that is not raw. c00 to c11: coordinates of the group's corners. */
bool cbvhIntersectsGroup(CbvhVertBlock block, CbvhPreparedRay ray, CbvhVertRay vert, CbvhVertAxes axes, float tfar,
                         uint g, ivec3 c00, ivec3 c10, ivec3 c01, ivec3 c11) {
  RayInterval interval = RayInterval(ray.tnear, tfar);
  for (int k = 0; k < 3; k++) {
    uint margins = byteAt(block.at, block.firstStep.margins + uint(k) * block.groups + g);
    interval = cbvhClippedByPlanes(interval, ray, vert, axes,
                                   planesOfGroup(block.firstStep, axes.info, c00, c10, c01, c11, margins, k), k);
  }
  return interval.from <= interval.to;
}

/* Tests the box of group g of a static raw block. */
bool cbvhIntersectsRawGroup(CbvhVertBlock block, CbvhPreparedRay ray, CbvhVertRay vert, float tfar, uint g) {
  RayInterval interval = RayInterval(ray.tnear, tfar);
  VertLayout offsets = vertLayout(block.region, block.info);
  for (int k = 0; k < 3; k++) {
    BoxPlanes planes = rawPlanesOfGroup(block.at, offsets, g, k);
    float highest = block.firstStep.origin[k];
    for (uint i = 0u; i < block.groups; i++) highest = max(highest, rawPlanesOfGroup(block.at, offsets, i, k).upper);
    float slack = boxSlack(ray.org[k], block.firstStep.origin[k], highest - block.firstStep.origin[k]);
    interval =
        clipInterval(interval, (planes.lower - ray.org[k]) - slack, (planes.upper - ray.org[k]) + slack, vert.rcp[k]);
  }
  return interval.from <= interval.to;
}

#endif
