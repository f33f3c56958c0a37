// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Decodes boxes of a cVERT block's groups, on CPUs and GPUs. */

#ifndef CVERT_DECODER_GROUP_PLANES_H
#define CVERT_DECODER_GROUP_PLANES_H

#include "../portable/int3.h"
#include "step_view.h"

CVERT_BEGIN

/*! Planes of a box on an axis, in world space. On the sheared axis they bound h of block.h, relative to the step's
 *  origin. */
struct BoxPlanes {
  float lower, upper;
};

/*! Planes of a group: the bounds of its corners, enlarged by margins. c00 to c11: coordinates of the corners. margins:
 *  the group's byte for the axis. info and margins are of the block, or, if it moves, of the step with which the
 *  segment begins. Neither the step nor the other end of the segment may be raw. */
CVERT_FUNCTION BoxPlanes planesOfGroup(CVERT_IN(StepView) step, uint32_t info, Int3 c00, Int3 c10, Int3 c01, Int3 c11,
                                       uint32_t margins, int axis) {
  int m = shearedAxis(info);
  float a = float(c00[axis]), b = float(c10[axis]), c = float(c01[axis]), d = float(c11[axis]);
  if (axis == m) {
    int k = axisAfter(m, 1), l = axisAfter(m, 2);
    float s = shearFactor(info, 1, step.spacing), t = shearFactor(info, 2, step.spacing);
    a = a + s * float(c00[k]) + t * float(c00[l]);
    b = b + s * float(c10[k]) + t * float(c10[l]);
    c = c + s * float(c01[k]) + t * float(c01[l]);
    d = d + s * float(c11[k]) + t * float(c11[l]);
  }
  float least = CVERT_AS_FLOAT(minimum)(CVERT_AS_FLOAT(minimum)(a, b), CVERT_AS_FLOAT(minimum)(c, d));
  float greatest = CVERT_AS_FLOAT(maximum)(CVERT_AS_FLOAT(maximum)(a, b), CVERT_AS_FLOAT(maximum)(c, d));
  uint32_t shift = marginShift(info, axis);
  float origin = axis == m ? 0.0f : step.origin[axis], spacing = step.spacing.at[axis];
  BoxPlanes planes;
  planes.lower = origin + (least - float(lowerMargin(margins, shift))) * spacing;
  planes.upper = origin + (greatest + float(upperMargin(margins, shift))) * spacing;
  return planes;
}

/*! Planes of group g of a raw block. offsets: vertLayout of the block. */
CVERT_FUNCTION BoxPlanes rawPlanesOfGroup(CVERT_POINTER(VertHeader) block, CVERT_IN(VertLayout) offsets, uint32_t g,
                                          int axis) {
  BoxPlanes planes;
  planes.lower = floatAt(block, offsets.boxes / 4u + uint32_t(axis) * offsets.groups + g);
  planes.upper = floatAt(block, offsets.boxes / 4u + uint32_t(3 + axis) * offsets.groups + g);
  return planes;
}

CVERT_END

#endif
