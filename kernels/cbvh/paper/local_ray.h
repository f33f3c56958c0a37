// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A ray in the frame of a block: scalar version for shaders and tests. local_ray4.h is the SIMD version.
 *
 * The projective map transforms the part of the ray inside the block's box to a segment P(s) = P0 + s (P1-P0), s in
 * [0,1]. Traversal uses s only. The world parameter follows exactly from W at both ends:
 *
 *   tau(s) = s w0 / (w1 (1-s) + s w0),   t = t0 + tau (t1-t0)
 *
 * Numerics. The ray's origin is first moved to its point nearest to the block's center, relative to that center. This
 * loses a few ulps of the distance between ray origin and block, as in any float ray tracer, and of the block's size:
 * position and direction are rounded by 3/2 ulps of their terms, and no point of the box is much farther from the
 * center than its longest side. This loss, times the map's stretch of each axis and of W, plus a few ulps of 1, all
 * divided by W, is the vector "epsilon", by which traversal widens every bound. Blocks see a ray displaced by less than
 * their epsilons, so no ray passes between neighbors. */

#ifndef CBVH_PAPER_LOCAL_RAY_H
#define CBVH_PAPER_LOCAL_RAY_H

#include "block.h"
#include "node.h"

CBVH_BEGIN

/*! Bounds of a ray's displacement, see above: in ulps of its distance from the block, and in ulps of 1. Shaders divide
 *  with errors of up to 2.5 ulps instead of 1/2. This adds 2 ulps of 1 each to the segment's ends, their clipping and
 *  the reciprocals of its direction. Other quotients only shift the point from which distances are measured. */
CVERT_CONSTANT float distanceUlps = 4.0f;
#ifdef VULKAN
CVERT_CONSTANT float unitUlps = 14.0f;
#else
CVERT_CONSTANT float unitUlps = 8.0f;
#endif

/*! Assumed radius of a box, relative to r = 1/(the smallest stretch of x, y and z). If sides are orthogonal, they are
 *  at most sqrt(3) r long, and points at most 3/2 r from the center. Their displacement, 3/2 ulps of 3/2 r, is less
 *  than distanceUlps of this radius. */
CVERT_CONSTANT float relativeBoxRadius = 0.75f;

/*! Represents infinity in ranges of parameters. */
CVERT_CONSTANT float beyondAll = 3.0e38f;

CVERT_REAL struct Range {
  Real lower, upper;
};

CVERT_REAL CVERT_FUNCTION CVERT_OF(Range) makeRange(Real lower, Real upper) {
  CVERT_OF(Range) range;
  range.lower = lower;
  range.upper = upper;
  return range;
}

/*! Clips a range of s to the part where o + s d >= 0. */
CVERT_REAL CVERT_FUNCTION CVERT_OF(Range) clipRange(CVERT_OF(Range) range, Real o, Real d) {
  if (d > Real(0)) range.lower = maximum(range.lower, -o / d);
  else if (d < Real(0)) range.upper = minimum(range.upper, -o / d);
  else if (o < Real(0)) range.upper = Real(-beyondAll);
  return range;
}

/*! tnear, tfar: in units of dir. */
CVERT_REAL struct WorldRay {
  Real org[3], dir[3];
  Real tnear, tfar;
};

/*! The part of a ray in a block's box. */
CVERT_REAL struct Segment {
  Real P0[3], P1[3]; //!< both ends in the frame
  Real epsilon[3];   //!< see the top of this file
  Real t0, t1;       //!< parameters of the ray at both ends
  Real w0, w1;       //!< W at both ends
  bool startClipped; //!< starts at tnear, inside the box
  bool endClipped;   //!< ends at tfar, inside the box
  bool valid;        //!< false for a miss
};

/*! Component k of epsilon, times W. distance: largest component of the ray's origin relative to the center. */
CVERT_REAL CVERT_FUNCTION Real rayEpsilon(BlockHeader block, Real distance, int k) {
  Real shortest = Real(beyondAll), stretchK = Real(0), stretchW = Real(0);
  for (int j = 0; j < 4; j++) {
    Real stretch = Real(0);
    for (int i = 0; i < 3; i++) stretch += magnitude(Real(block.columns[i][j]));
    if (j == k) stretchK = stretch;
    if (j == 3) stretchW = stretch;
    else shortest = minimum(shortest, stretch);
  }
  Real farthest = distance + Real(relativeBoxRadius) / shortest;
  return Real(distanceUlps * floatUlp) * farthest * (stretchK + stretchW) + Real(unitUlps * floatUlp);
}

/*! Maps a ray into a block's frame, and clips it to the block's box. widening: factor of epsilon, 1 in traversal. */
CVERT_REAL CVERT_FUNCTION CVERT_OF(Segment) enterBlock(BlockHeader block, CVERT_OF(WorldRay) ray, Real widening) {
  Real o[3], od = Real(0), dd = Real(0), distance = Real(0);
  for (int i = 0; i < 3; i++) {
    o[i] = ray.org[i] - Real(block.center[i]);
    od += o[i] * ray.dir[i];
    dd += ray.dir[i] * ray.dir[i];
    distance = maximum(distance, magnitude(o[i]));
  }
  Real tref = -od / dd;
  Real O[4], D[4];
  for (int k = 0; k < 4; k++) {
    O[k] = k == 3 ? Real(1) : Real(0.5f);
    D[k] = Real(0);
    for (int i = 0; i < 3; i++) {
      O[k] += (o[i] + tref * ray.dir[i]) * Real(block.columns[i][k]);
      D[k] += ray.dir[i] * Real(block.columns[i][k]);
    }
  }

  CVERT_OF(Segment) segment;
  /* clips to X >= 0, W-X >= 0, and so on, which are linear in the parameter */
  CVERT_OF(Range) inBox = makeRange(Real(-beyondAll), Real(beyondAll));
  for (int k = 0; k < 3; k++) {
    segment.epsilon[k] = widening * rayEpsilon(block, distance, k);
    inBox = clipRange(inBox, O[k] + segment.epsilon[k], D[k]);
    inBox = clipRange(inBox, O[3] - O[k] + segment.epsilon[k], D[3] - D[k]);
  }
  Real tauNear = ray.tnear - tref, tauFar = ray.tfar - tref;
  segment.startClipped = tauNear > inBox.lower;
  segment.endClipped = tauFar < inBox.upper;
  Real tau0 = maximum(tauNear, inBox.lower), tau1 = minimum(tauFar, inBox.upper);
  segment.t0 = tref + tau0;
  segment.t1 = tref + tau1;
  segment.w0 = O[3] + tau0 * D[3];
  segment.w1 = O[3] + tau1 * D[3];
  segment.valid = tau0 <= tau1 && segment.w0 > Real(0) && segment.w1 > Real(0);
  for (int k = 0; k < 3; k++) {
    segment.P0[k] = (O[k] + tau0 * D[k]) / segment.w0;
    segment.P1[k] = (O[k] + tau1 * D[k]) / segment.w1;
    segment.epsilon[k] /= minimum(segment.w0, segment.w1);
  }
  return segment;
}

/*! tau(s), see above. */
CVERT_REAL CVERT_FUNCTION Real worldFraction(Real w0, Real w1, Real s) {
  Real sw = s * w0;
  return sw / (w1 * (Real(1) - s) + sw);
}

/*! Inverse of worldFraction. Rounds like NodeRays::parameterAfter. */
CVERT_REAL CVERT_FUNCTION Real localFraction(Real w0, Real w1, Real tau) {
  Real tw = product(tau, w1);
  return tw / (product(w0, Real(1) - tau) + tw);
}

/*! Distance along the world-space ray at s. */
CVERT_REAL CVERT_FUNCTION Real worldT(CVERT_OF(Segment) segment, Real s) {
  return segment.t0 + worldFraction(segment.w0, segment.w1, s) * (segment.t1 - segment.t0);
}

CVERT_REAL CVERT_FUNCTION Real segmentAt(CVERT_OF(Segment) segment, int axis, Real s) {
  return segment.P0[axis] + s * (segment.P1[axis] - segment.P0[axis]);
}

/*! Range of s in which the segment's line is inside of a box widened by epsilon, on the first `axes` (2 or 3) axes. */
CVERT_REAL CVERT_FUNCTION CVERT_OF(Range) rangeInBox(CVERT_OF(Segment) segment, NodeBox box, int axes) {
  CVERT_OF(Range) range = makeRange(Real(-beyondAll), Real(beyondAll));
  for (int k = 0; k < axes; k++) {
    Real d = segment.P1[k] - segment.P0[k];
    range = clipRange(range, segment.P0[k] - Real(box.lower[k]) + segment.epsilon[k], d);
    range = clipRange(range, Real(upperOf(box, k)) - segment.P0[k] + segment.epsilon[k], -d);
  }
  return range;
}

/*! True if a range of s overlaps [0,1]. */
CVERT_REAL CVERT_FUNCTION bool isOnSegment(CVERT_OF(Range) range) {
  return maximum(range.lower, Real(0)) <= minimum(range.upper, Real(1));
}

CBVH_END

#endif
