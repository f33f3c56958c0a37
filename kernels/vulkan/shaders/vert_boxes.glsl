// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A ray and the bounds of a block of cVERT, and the boxes of its groups. They only cull: planes are exact, or linear between exact ones, and
 * are widened as kernels/cvert/rule/rule.h says. */

#ifndef CBVH_VERT_BOXES_GLSL
#define CBVH_VERT_BOXES_GLSL

#include "ray.glsl"
#include "vert_vertices.glsl"
#include "../../cvert/rule/rule.h"

/* What of a ray all blocks need. */
struct CbvhVertRay
{
  vec3 rcp;        // finite
  float largest;   // of the components of the direction
};

CbvhVertRay cbvhVertRay (CbvhTravel ray)
{
  CbvhVertRay vert;
  vec3 size = abs(ray.dir);
  vert.largest = max(size.x, max(size.y, size.z));
  for (int k = 0; k < 3; k++) vert.rcp[k] = directionReciprocal(ray.dir[k], vert.largest);
  return vert;
}

/* Axes of the boxes of a block that is not raw, and the ray along the sheared one, from the block's origin. */
struct CbvhVertAxes
{
  uint boxForm;
  vec3 origin;
  float extent;              // of the block from its origin, at least
  float org, rcp, error;     // of the ray along the sheared coordinate
};

int cbvhNextAxis (int axis, int by) { return axis + by < 3 ? axis + by : axis + by - 3; }

/* what component k counts in the sheared coordinate */
float cbvhShearOf (uint boxForm, int k)
{
  int m = shearedAxis(boxForm), i = k >= m ? k - m : k - m + 3;
  return i == 0 ? 1.0 : float(shearSlope(boxForm, i))*(1.0/16.0);
}

CbvhVertAxes cbvhVertAxes (uint boxForm, vec3 origin, float extent, CbvhTravel ray, CbvhVertRay vert)
{
  ShearedCoordinate along = noShearedCoordinate();
  for (int k = 0; k < 3; k++) along = addSheared(along, ray.org[k], ray.dir[k], origin[k], extent, cbvhShearOf(boxForm, k));
  return CbvhVertAxes(boxForm, origin, extent, along.org, directionReciprocal(along.dir, vert.largest), shearedSlack(along.size));
}

void cbvhClip (inout float tNear, inout float tFar, float lower, float upper, float rcp)
{
  float a = lower*rcp, b = upper*rcp;
  tNear = max(tNear, min(a, b));
  tFar = min(tFar, max(a, b));
}

float cbvhSlack (CbvhVertAxes axes, CbvhTravel ray, int k) { return boxSlack(ray.org[k], axes.origin[k], axes.extent); }

/* the four planes of a block's reach: VertHeader. step_: in spacings */
vec4 cbvhReach (uint boxForm, uint reach, float step_, VertSpacing spacing)
{
  int m = shearedAxis(boxForm);
  float sheared = step_*spacing.at[m];
  return vec4(float(reachOf(reach, 0))*step_*spacing.at[cbvhNextAxis(m, 1)], float(reachOf(reach, 1))*step_*spacing.at[cbvhNextAxis(m, 2)],
              float(reachOf(reach, 2))*sheared, float(reachOf(reach, 3))*sheared);
}

/* Whether the ray meets the bounds of a block. slack: what they may be too small by, on each axis */
bool cbvhMeetsBounds (CbvhTravel ray, CbvhVertRay vert, CbvhVertAxes axes, vec4 reach, vec3 slack, float tfar)
{
  int m = shearedAxis(axes.boxForm);
  float tNear = ray.tnear, tFar = tfar;
  for (int i = 0; i < 2; i++) {
    int k = cbvhNextAxis(m, 1 + i);
    float from = axes.origin[k] - ray.org[k], wide = cbvhSlack(axes, ray, k) + slack[k];
    cbvhClip(tNear, tFar, from - wide, (from + reach[i]) + wide, vert.rcp[k]);
  }
  float wide = axes.error + slack[m];
  cbvhClip(tNear, tFar, (reach.z - axes.org) - wide, (reach.w - axes.org) + wide, axes.rcp);
  return tNear <= tFar;
}

float cbvhLeast (vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
float cbvhGreatest (vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

/* Planes of a group's box at a step, along an axis: lower and upper. margins: a byte; c00 to c11: corners of the group */
vec2 cbvhPlanes (uint boxForm, CbvhVertStep step_, vec3 c00, vec3 c10, vec3 c01, vec3 c11, uint margins, int k)
{
  uint shift = marginShift(boxForm, k);
  int m = shearedAxis(boxForm);
  vec4 corners = vec4(c00[k], c10[k], c01[k], c11[k]);
  if (k == m) {
    int n = cbvhNextAxis(m, 1), l = cbvhNextAxis(m, 2);
    corners += shearFactor(boxForm, 1, step_.spacing)*vec4(c00[n], c10[n], c01[n], c11[n])
             + shearFactor(boxForm, 2, step_.spacing)*vec4(c00[l], c10[l], c01[l], c11[l]);
  }
  float origin = k == m ? 0.0 : step_.origin[k];
  return vec2((cbvhLeast(corners) - float(lowerMargin(margins, shift)))*step_.spacing.at[k] + origin,
              (cbvhGreatest(corners) + float(upperMargin(margins, shift)))*step_.spacing.at[k] + origin);
}

/* clips the ray by such planes */
void cbvhClipByPlanes (inout float tNear, inout float tFar, CbvhTravel ray, CbvhVertRay vert, CbvhVertAxes axes, vec2 planes, int k)
{
  bool isSheared = k == shearedAxis(axes.boxForm);
  float from = isSheared ? axes.org : ray.org[k], error = isSheared ? axes.error : cbvhSlack(axes, ray, k);
  cbvhClip(tNear, tFar, (planes.x - from) - error, (planes.y - from) + error, isSheared ? axes.rcp : vert.rcp[k]);
}

/* whether the ray meets the box of group g of a block that is not raw, whose corners are given */
bool cbvhMeetsGroup (CbvhVertBlock block, CbvhTravel ray, CbvhVertRay vert, CbvhVertAxes axes, float tfar, uint g, vec3 c00, vec3 c10, vec3 c01, vec3 c11)
{
  float tNear = ray.tnear, tFar = tfar;
  for (int k = 0; k < 3; k++) {
    uint margins = cbvhByte(block.at, block.first.margins + uint(k)*block.groups + g);
    cbvhClipByPlanes(tNear, tFar, ray, vert, axes, cbvhPlanes(axes.boxForm, block.first, c00, c10, c01, c11, margins, k), k);
  }
  return tNear <= tFar;
}

/* the same of a raw block */
bool cbvhMeetsRawGroup (CbvhVertBlock block, CbvhTravel ray, CbvhVertRay vert, float tfar, uint g)
{
  float tNear = ray.tnear, tFar = tfar;
  uint first = vertLayout(block.region, block.boxForm).boxes/4u;
  for (int k = 0; k < 3; k++) {
    float lower = cbvhFloat(block.at, first + uint(k)*block.groups + g), upper = cbvhFloat(block.at, first + uint(3 + k)*block.groups + g);
    float highest = block.first.origin[k];
    for (uint i = 0u; i < block.groups; i++) highest = max(highest, cbvhFloat(block.at, first + uint(3 + k)*block.groups + i));
    float slack = boxSlack(ray.org[k], block.first.origin[k], highest - block.first.origin[k]);
    cbvhClip(tNear, tFar, (lower - ray.org[k]) - slack, (upper - ray.org[k]) + slack, vert.rcp[k]);
  }
  return tNear <= tFar;
}

#endif
