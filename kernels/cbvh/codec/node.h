// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Words of inner nodes: 32 bits hold the bounds of 4 children, relative to the decoded
 * bounds of their parent. The children are the 2 x 2 quadrants of the parent's quads, in
 * Morton order (child = column + 2 row).
 *
 *   column      0        1          Siblings share planes: both children of a
 *            |-----|  |-----|       column (row) have the same two x (y) planes,
 *            A     B  C     D       so 8 planes bound all four. A and D are the
 *       parent's x range            outer planes, B and C the inner ones; B and C
 *                                   overlap where the surface does.
 *
 * z has one interval a child, out of a book of 8.
 *
 * Decoding is lower + T * extent in float, T a multiple of 1/256: contracted to a fused
 * multiply-add or not, one step is off by at most one ulp of a number below 2, so after 8
 * levels by less than 2^-20. The encoder keeps every decoded plane at least
 * containmentSlack away from the geometry, therefore bounds contain it on every ISA,
 * whatever the compiler contracts.
 *
 * Based on: Selgrad et al., "A Compressed Representation for Ray Tracing Parametric
 * Surfaces", 2016 (relative bounds, shared planes). */

#ifndef CBVH_NODE_H
#define CBVH_NODE_H

#include "morton.h"

CBVH_BEGIN

/*! bounds in the block's frame, where the block's own box is [0,1]^3 */
struct NodeBox
{
  float lower[3];
  float extent[3];
};

CBVH_FUNCTION NodeBox rootBox ()
{
  NodeBox box;
  for (int k=0; k<3; k++) { box.lower[k] = 0.0f; box.extent[k] = 1.0f; }
  return box;
}

CBVH_FUNCTION float upperOf (NodeBox box, int axis) { return box.lower[axis] + box.extent[axis]; }

/*! distance that decoded planes keep from the geometry, see above */
CBVH_CONSTANT float containmentSlack = 1.0f/1048576.0f;

/*! Outer planes: distance from the parent's plane, in parent extents. They only win back
 *  what the parent's own rounding lost, hence small steps. */
CBVH_CONSTANT float outerOffsets[4] = { 0.0f, 6.0f/256.0f, 16.0f/256.0f, 36.0f/256.0f };

/*! Inner planes: position of column 0's upper plane; column 1's lower plane mirrors it.
 *  Fine around the middle, where patch-aligned frames put it, and 1 for surfaces that fold
 *  over their neighbour. */
CBVH_CONSTANT float innerPositions[8] = {
  116.0f/256.0f, 125.0f/256.0f, 130.0f/256.0f, 136.0f/256.0f, 144.0f/256.0f, 160.0f/256.0f, 192.0f/256.0f, 1.0f
};

/*! z intervals in parent extents; the first one always contains. The others make the mean
 *  logarithm of a child's height smallest over blocks of real and of analytic
 *  displacements: 8% less a level than halves and quarters. */
struct Interval { float lower, upper; };
CBVH_CONSTANT Interval zIntervals[8] = {
  { 0.0f, 1.0f },         { 0.21875f, 0.8125f },  { 0.0625f, 0.625f }, { 0.5f, 1.0f },
  { 0.34375f, 0.71875f }, { 0.21875f, 0.59375f }, { 0.4375f, 0.875f }, { 0.0f, 0.46875f }
};

/* Bits of a word. A plane pair is 5 bits: 2 for the outer plane, then 3 for the inner one.
 *
 *   bits  0..4   x lower planes of columns 0 (outer) and 1 (inner)
 *   bits  5..9   x upper planes of columns 1 (outer) and 0 (inner)
 *   bits 10..14  y lower planes of rows 0 and 1
 *   bits 15..19  y upper planes of rows 1 and 0
 *   bits 20..31  z interval of children 0 to 3, 3 bits each */
CBVH_CONSTANT int planePairBits = 5;
CBVH_CONSTANT uint32_t planePairMask = 31u;
CBVH_CONSTANT int zShift = 20;
CBVH_CONSTANT int zBits = 3;

CBVH_FUNCTION int lowerShift (int axis) { return axis*2*planePairBits; }
CBVH_FUNCTION int upperShift (int axis) { return axis*2*planePairBits + planePairBits; }

/*! lower (upper) plane of a column, in parent extents, from the 5 bits of its pair */
CBVH_FUNCTION float lowerPlane (uint32_t pair, int column) {
  return column == 0 ? outerOffsets[pair & 3u] : 1.0f - innerPositions[(pair >> 2) & 7u];
}
CBVH_FUNCTION float upperPlane (uint32_t pair, int column) {
  return column == 1 ? 1.0f - outerOffsets[pair & 3u] : innerPositions[(pair >> 2) & 7u];
}

CBVH_FUNCTION uint32_t zCode (uint32_t word, int child) { return (word >> (zShift + zBits*child)) & 7u; }

/*! bounds of a child, from its parent's word and bounds */
CBVH_FUNCTION NodeBox decodeChild (uint32_t word, int child, NodeBox parent)
{
  NodeBox box;
  for (int axis=0; axis<2; axis++)
  {
    int column = childColumn(child,axis);
    float lower = parent.lower[axis] + lowerPlane((word >> lowerShift(axis)) & planePairMask,column)*parent.extent[axis];
    float upper = parent.lower[axis] + upperPlane((word >> upperShift(axis)) & planePairMask,column)*parent.extent[axis];
    box.lower[axis] = lower;
    box.extent[axis] = upper - lower;
  }
  uint32_t z = zCode(word,child);
  float lower = parent.lower[2] + zIntervals[z].lower*parent.extent[2];
  float upper = parent.lower[2] + zIntervals[z].upper*parent.extent[2];
  box.lower[2] = lower;
  box.extent[2] = upper - lower;
  return box;
}

CBVH_END

#endif
