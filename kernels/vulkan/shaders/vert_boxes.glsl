// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A ray and the bounds of a block of cVERT, and the boxes of its groups. They only cull: planes are exact, or linear between exact ones, and
 * are widened as kernels/cvert/rule/rule.h says. */

#ifndef CBVH_VERT_BOXES_GLSL
#define CBVH_VERT_BOXES_GLSL

#include "ray.glsl"
#include "vert_cell.glsl"
#include "../../cvert/decoder/group_planes.h"
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

/* what component k counts in the sheared coordinate */
float cbvhShearOf (uint boxForm, int k)
{
  int m = shearedAxis(boxForm);
  return shearOf(boxForm, k >= m ? k - m : k - m + 3);
}

CbvhVertAxes cbvhVertAxes (uint boxForm, vec3 origin, float extent, CbvhTravel ray, CbvhVertRay vert)
{
  ShearedCoordinate along = noShearedCoordinate();
  for (int k = 0; k < 3; k++) along = addSheared(along, ray.org[k], ray.dir[k], origin[k], extent, cbvhShearOf(boxForm, k));
  return CbvhVertAxes(boxForm, origin, extent, along.org, directionReciprocal(along.dir, vert.largest), shearedSlack(along.size));
}

float cbvhSlack (CbvhVertAxes axes, CbvhTravel ray, int k) { return boxSlack(ray.org[k], axes.origin[k], axes.extent); }

/* Whether the ray meets the bounds of a block. slack: what they may be too small by, on each axis */
bool cbvhMeetsBounds (CbvhTravel ray, CbvhVertRay vert, CbvhVertAxes axes, BlockReach reach, vec3 slack, float tfar)
{
  int m = shearedAxis(axes.boxForm);
  RayInterval interval = RayInterval(ray.tnear, tfar);
  for (int i = 0; i < 2; i++) {
    int k = axisAfter(m, 1 + i);
    float from = axes.origin[k] - ray.org[k], wide = cbvhSlack(axes, ray, k) + slack[k];
    interval = clipped(interval, from - wide, (from + reach.upper[i]) + wide, vert.rcp[k]);
  }
  float wide = axes.error + slack[m];
  interval = clipped(interval, (reach.sheared[0] - axes.org) - wide, (reach.sheared[1] - axes.org) + wide, axes.rcp);
  return interval.from <= interval.to;
}

/* clips the ray by planes of a group's box */
RayInterval cbvhClippedByPlanes (RayInterval interval, CbvhTravel ray, CbvhVertRay vert, CbvhVertAxes axes, BoxPlanes planes, int k)
{
  bool isSheared = k == shearedAxis(axes.boxForm);
  float from = isSheared ? axes.org : ray.org[k], error = isSheared ? axes.error : cbvhSlack(axes, ray, k);
  return clipped(interval, (planes.lower - from) - error, (planes.upper - from) + error, isSheared ? axes.rcp : vert.rcp[k]);
}

/* --- blocks that do not move ------------------------------------------------------------ */

/* Axes of the boxes of a block that does not move and is not raw, in the order m, m+1, m+2. Axis m is sheared. */
struct CbvhBoxes
{
  vec3 lower, upper;   // the block's origin, from where the ray starts, less what planes are widened by, and with it
  vec3 rcp, spacing;
  vec3 shear;          // what coordinates count in the sheared one
  BlockReach reach;
  uint form;
};

/* Reads only the header. */
CbvhBoxes cbvhBoxes (uvec4 header[4], CbvhTravel ray)
{
  CbvhBoxes boxes;
  boxes.form = header[3].z;
  int m = shearedAxis(boxes.form);
  VertSpacing spacing = vertSpacing(header[3].w, header[2].x, header[2].y, header[2].z, header[2].w);
  boxes.spacing = cbvhFromAxis(m, vec3(spacing.at[0], spacing.at[1], spacing.at[2]));
  uint reach = header[0].w;
  vec3 unit = float(reachStep(boxes.form))*boxes.spacing;
  boxes.reach.upper[0] = float(reachOf(reach, 0))*unit.y;
  boxes.reach.upper[1] = float(reachOf(reach, 1))*unit.z;
  boxes.reach.sheared[0] = float(reachOf(reach, 2))*unit.x;
  boxes.reach.sheared[1] = float(reachOf(reach, 3))*unit.x;
  float extent = extentOfReach(boxes.reach);

  vec3 shear = vec3(shearOf(boxes.form, 0), shearOf(boxes.form, 1), shearOf(boxes.form, 2));
  boxes.shear = shear*boxes.spacing/boxes.spacing.x;
  vec3 origin = cbvhFromAxis(m, uintBitsToFloat(header[0].xyz));
  vec3 org = cbvhFromAxis(m, ray.org), dir = cbvhFromAxis(m, ray.dir);
  ShearedCoordinate along = noShearedCoordinate();
  [[unroll]] for (int k = 0; k < 3; k++) along = addSheared(along, org[k], dir[k], origin[k], extent, shear[k]);
  vec3 slack = vec3(shearedSlack(along.size), boxSlack(org.y, origin.y, extent), boxSlack(org.z, origin.z, extent));
  vec3 size = abs(dir);
  vec3 from = vec3(-along.org, origin.yz - org.yz);
  boxes.lower = from - slack;
  boxes.upper = from + slack;
  boxes.rcp = cbvhFromAxis(m, ray.rcp);
  boxes.rcp.x = directionReciprocal(along.dir, max(size.x, max(size.y, size.z)));
  return boxes;
}

/* Whether the ray meets a box whose planes are so far from the block's origin. */
bool cbvhMeetsBox (CbvhBoxes boxes, CbvhTravel ray, vec3 lower, vec3 upper, float tfar)
{
  vec3 a = (lower + boxes.lower)*boxes.rcp, b = (upper + boxes.upper)*boxes.rcp;
  vec3 enter = min(a, b), leave = max(a, b);
  return max(max(enter.x, enter.y), max(enter.z, ray.tnear)) <= min(min(leave.x, leave.y), min(leave.z, tfar));
}

/* Whether the ray meets the bounds of the block. */
bool cbvhMeetsBounds (CbvhBoxes boxes, CbvhTravel ray, float tfar)
{
  BlockReach reach = boxes.reach;
  vec3 lower = vec3(reach.sheared[0], 0.0, 0.0), upper = vec3(reach.sheared[1], reach.upper[0], reach.upper[1]);
  return cbvhMeetsBox(boxes, ray, lower, upper, tfar);
}

/* A corner of a group, from its coordinates on the axes m, m+1, m+2. */
vec3 cbvhBoxCorner (CbvhBoxes boxes, ivec3 c)
{
  vec3 corner = vec3(c);
  corner.x = corner.x + boxes.shear.y*corner.y + boxes.shear.z*corner.z;
  return corner;
}

/* Margins of up to four groups that follow each other, a byte each, on the axes m, m+1, m+2. */
uvec3 cbvhMargins (CbvhVertBlock block, uint g)
{
  int m = shearedAxis(block.boxForm);
  uvec3 axis = uvec3(m, axisAfter(m, 1), axisAfter(m, 2)), begin = 8u*(block.first.margins + axis*block.groups + g);
  return uvec3(bitsAt(block.at, begin.x, 32u), bitsAt(block.at, begin.y, 32u), bitsAt(block.at, begin.z, 32u));
}

/* Whether the ray meets the box of a group, which is that of planesOfGroup. least, greatest: of cbvhBoxCorner of its
 * corners; margins: only their lowest bytes are used */
bool cbvhMeetsGroup (CbvhBoxes boxes, CbvhTravel ray, vec3 least, vec3 greatest, uvec3 margins, float tfar)
{
  int m = shearedAxis(boxes.form);
  uvec3 shift;
  [[unroll]] for (int k = 0; k < 3; k++) shift[k] = marginShift(boxes.form, axisAfter(m, k));
  vec3 lower = least - vec3((margins & 15u) << shift), upper = greatest + vec3(((margins >> 4) & 15u) << shift);
  return cbvhMeetsBox(boxes, ray, lower*boxes.spacing, upper*boxes.spacing, tfar);
}

/* the same of a raw block */
bool cbvhMeetsRawGroup (CbvhVertBlock block, CbvhTravel ray, CbvhVertRay vert, float tfar, uint g)
{
  RayInterval interval = RayInterval(ray.tnear, tfar);
  VertLayout offsets = vertLayout(block.region, block.boxForm);
  for (int k = 0; k < 3; k++) {
    BoxPlanes planes = rawPlanesOfGroup(block.at, offsets, g, k);
    float highest = block.first.origin[k];
    for (uint i = 0u; i < block.groups; i++) highest = max(highest, rawPlanesOfGroup(block.at, offsets, i, k).upper);
    float slack = boxSlack(ray.org[k], block.first.origin[k], highest - block.first.origin[k]);
    interval = clipped(interval, (planes.lower - ray.org[k]) - slack, (planes.upper - ray.org[k]) + slack, vert.rcp[k]);
  }
  return interval.from <= interval.to;
}

#endif
