// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* World-space normals of hits in blocks with frames. Compiles as C++ and GLSL; block_hit.h is the version of the CPU's
 * traversal. */

#ifndef CBVH_PAPER_NORMAL_H
#define CBVH_PAPER_NORMAL_H

#include "block.h"
#include "leaf/hit_rule.h"

CBVH_BEGIN

CVERT_REAL struct Vector {
  Real x[3];
};

/*! Returns the world-space normal, not normalized, of the plane z = slopeX x + slopeY y + const through a point p of
 *  the frame. If M maps world space to homogeneous coordinates of the frame, plane (a,b,c,d) of the frame is plane
 *  (a,b,c,d) M of world space: no inverse is required. */
CVERT_REAL CVERT_FUNCTION CVERT_OF(Vector)
    worldNormal(BlockHeader block, CVERT_OF(Vector) p, Real slopeX, Real slopeY) {
  CVERT_OF(Vector) normal;
  Real k = p.x[2] - slopeX * p.x[0] - slopeY * p.x[1];
  for (int i = 0; i < 3; i++)
    normal.x[i] = Real(block.columns[i][2]) - slopeX * Real(block.columns[i][0]) - slopeY * Real(block.columns[i][1]) -
                  k * Real(block.columns[i][3]);
  return normal;
}

/*! Squared sine of 30 degrees. At a step behind a silhouette, the surface can face away from the ray. A normal that
 *  faces away by less than this angle is mirrored at the plane orthogonal to the ray. */
CVERT_CONSTANT float mirroredSine2 = 0.25f;

/*! along: dot product of normal and direction. normal2, direction2: their squared lengths. from: HitResult::from of
 *  leaf/hit_rule.h. */
CVERT_REAL CVERT_FUNCTION bool isMirrored(Real along, Real normal2, Real direction2, uint32_t from) {
  bool away = (from == sideAbove && along > Real(0)) || (from == sideBelow && along < Real(0));
  return away && along * along < Real(mirroredSine2) * normal2 * direction2;
}

CBVH_END

#endif
