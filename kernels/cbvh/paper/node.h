// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Format of inner nodes: a word of 32 bits for the bounds of 4 children, relative to their parent's decoded bounds. The
 * children are the 2 x 2 quadrants of the parent's quads, in Morton order (child = column + 2 row). node_decoder4.h is
 * the SIMD decoder. Compiles as C++ and GLSL.
 *
 *   column      0        1          Siblings share planes: both children of a
 *            |-----|  |-----|       column (row) have the same two x (y) planes,
 *            A     B  C     D       so 8 planes bound all four. A and D are the
 *       parent's x range            outer planes, B and C the inner ones. Columns
 *                                   overlap where the surface does.
 *
 * Each child has one z interval, from a codebook of 8.
 *
 * A plane is lower + T * extent in floats, where T is a multiple of 1/256. Per level, rounding moves it by at most
 * 2^-23, whether multiplications and additions are fused or not. 8 levels move it by at most 2^-20. The encoder keeps
 * its decoded planes this distance, containmentSlack, away from the geometry. So decoded bounds contain the geometry on
 * every ISA.
 *
 * Based on: Selgrad et al., "A Compressed Representation for Ray Tracing Parametric Surfaces", 2016 (relative bounds,
 * shared planes). */

#ifndef CBVH_PAPER_NODE_H
#define CBVH_PAPER_NODE_H

#include "morton.h"

CBVH_BEGIN

/*! Bounds of a node in the block's frame, in which the block's box is [0,1]^3. */
struct NodeBox {
  float lower[3];
  float extent[3];
};

CVERT_FUNCTION NodeBox rootBox() {
  NodeBox box;
  for (int k = 0; k < 3; k++) {
    box.lower[k] = 0.0f;
    box.extent[k] = 1.0f;
  }
  return box;
}

CVERT_FUNCTION float upperOf(NodeBox box, int axis) { return box.lower[axis] + box.extent[axis]; }

/*! Smallest distance between a plane that the encoder decodes and the geometry, in frame coordinates; see above. */
CVERT_CONSTANT float containmentSlack = 1.0f / 1048576.0f;

/* Codebooks are packed into words, because GPUs would load tables from memory. */

/*! Byte i, 0 to 7, of two words. */
CVERT_FUNCTION uint32_t packedByte(uint32_t low, uint32_t high, uint32_t i) {
  return ((i < 4u ? low : high) >> (8u * (i & 3u))) & 255u;
}

/*! Distance of an outer plane from the parent's plane, in parent extents: 0, 6/256, 16/256 or 36/256. The parent's
 *  plane is farther out than needed, because it is quantized and shared with a sibling. */
CVERT_FUNCTION float outerOffset(uint32_t code) { return float((0x24100600u >> (8u * code)) & 255u) * (1.0f / 256.0f); }

/*! Distance of an inner plane from the opposite plane of the parent, in parent extents: 116, 125, 130, 136, 144, 160,
 *  192 or 256, divided by 256. The packed bytes store these numbers minus 1. In frames that are aligned to patches,
 *  most planes are near the middle; 256 is for surfaces that fold over. */
CVERT_FUNCTION float innerPosition(uint32_t code) {
  return float(packedByte(0x87817C73u, 0xFFBF9F8Fu, code) + 1u) * (1.0f / 256.0f);
}

/*! z intervals in parent extents. The first always contains the child. The others minimize the mean logarithm of a
 *  child's height, over blocks of real and analytic displacements. In units of 1/32:
 *
 *    lower  0  7  2 16 11  7 14  0
 *    upper 32 26 20 32 23 19 28 15 */
struct Interval {
  float lower, upper;
};
CVERT_FUNCTION Interval zInterval(uint32_t code) {
  Interval z;
  z.lower = float(packedByte(0x10020700u, 0x000E070Bu, code)) * (1.0f / 32.0f);
  z.upper = float(packedByte(0x20141A20u, 0x0F1C1317u, code)) * (1.0f / 32.0f);
  return z;
}

/* Bits of a word. A plane pair has 2 bits for the outer plane, then 3 for the inner one.
 *
 *   bits  0..4   x lower planes of columns 0 (outer) and 1 (inner)
 *   bits  5..9   x upper planes of columns 1 (outer) and 0 (inner)
 *   bits 10..14  y lower planes of rows 0 and 1
 *   bits 15..19  y upper planes of rows 1 and 0
 *   bits 20..31  z interval of children 0 to 3, 3 bits each */
CVERT_CONSTANT int planePairBits = 5;
CVERT_CONSTANT uint32_t planePairMask = 31u;
CVERT_CONSTANT int zShift = 20;
CVERT_CONSTANT int zBits = 3;

CVERT_FUNCTION int lowerShift(int axis) { return axis * 2 * planePairBits; }
CVERT_FUNCTION int upperShift(int axis) { return axis * 2 * planePairBits + planePairBits; }

/*! Position of a child's lower or upper plane, in parent extents from the parent's lower plane. pair: the 5 bits of a
 *  plane pair. coordinate: column (row) of the child for x (y), 0 or 1. */
CVERT_FUNCTION float lowerPlane(uint32_t pair, int coordinate) {
  return coordinate == 0 ? outerOffset(pair & 3u) : 1.0f - innerPosition((pair >> 2) & 7u);
}
CVERT_FUNCTION float upperPlane(uint32_t pair, int coordinate) {
  return coordinate == 1 ? 1.0f - outerOffset(pair & 3u) : innerPosition((pair >> 2) & 7u);
}

CVERT_FUNCTION uint32_t zCode(uint32_t word, int child) { return (word >> (zShift + zBits * child)) & 7u; }

/*! Returns the decoded box of child 0 to 3 of a node. parent: decoded box of the node. */
CVERT_FUNCTION NodeBox decodeChild(uint32_t word, int child, NodeBox parent) {
  NodeBox box;
  for (int axis = 0; axis < 2; axis++) {
    int coordinate = childCoordinate(child, axis);
    float lower =
        parent.lower[axis] + lowerPlane((word >> lowerShift(axis)) & planePairMask, coordinate) * parent.extent[axis];
    float upper =
        parent.lower[axis] + upperPlane((word >> upperShift(axis)) & planePairMask, coordinate) * parent.extent[axis];
    box.lower[axis] = lower;
    box.extent[axis] = upper - lower;
  }
  Interval z = zInterval(zCode(word, child));
  float lower = parent.lower[2] + z.lower * parent.extent[2];
  float upper = parent.lower[2] + z.upper * parent.extent[2];
  box.lower[2] = lower;
  box.extent[2] = upper - lower;
  return box;
}

CBVH_END

#endif
