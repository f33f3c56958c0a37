// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Format of the leaves of cLEAF. A group of 2 x 2 leaves has a word, in place of a node of the last level, and 64 bits
 * of heights. lattice_encoder.h and separate_encoder.h encode groups; ../node_decoder4.h is the SIMD decoder. Compiles
 * as C++ and GLSL.
 *
 * Lattice: nine heights over three planes of x and three of y. Each of the four cells is a leaf with a bilinear
 * patch. Adjacent patches share edges.
 *
 *    y2 +-------+--------+   x0, x2, y0, y2 bound the group's quads; x1 and y1 run
 *       |   2   |    3   |   along its middle column and row of vertices. The surface
 *    y1 +-------+--------+   passes near the quads' vertices, wherever in their
 *       |   0   |    1   |   cells they are. Siblings do not overlap and have no steps
 *    y0 +-------+--------+   between them.
 *       x0     x1       x2
 *
 * Separate leaves: for quads that fold over each other, have holes or fit no lattice. The word is an inner node's. Each
 * child's box contains a plane of its own, is solid (the box is the surface), or is empty.
 *
 * The surface of a group, widened by half a thickness up and down in z, contains its quads' edges.
 *
 * Based on: Lier et al., "A High-Resolution Compression Scheme for Ray Tracing Subdivision Surfaces with Displacement",
 * 2018, section 4.1, which stores each corner of each quad in 4 bits. */

#ifndef CBVH_PAPER_LEAF_FORMAT_H
#define CBVH_PAPER_LEAF_FORMAT_H

#include "../node.h"

CBVH_BEGIN

/*! The 64 bits of a group. In a lattice, the lower 7 bits of bytes 0 to 7 are the heights of vertices 0 to 3 and 5 to
 *  8, row by row. The upper bits of bytes 0 to 6 are the height of the middle vertex, 4. The upper bit of byte 7 is set
 *  for groups of separate leaves. */
struct Heights {
  uint32_t low;  //!< bytes 0 to 3
  uint32_t high; //!< bytes 4 to 7
};

CVERT_FUNCTION bool hasSeparateLeaves(Heights heights) { return (heights.high >> 31) != 0u; }

/* --- lattices ------------------------------------------------------------------------ */

CVERT_CONSTANT int latticeBins = 128; //!< possible heights, of 7 bits
/*! Range of heights, relative to the group box's z extent. Exceeds 1: patches are extrapolated to the corners. */
CVERT_CONSTANT float latticeRange = 1.5f;

/*! Index of the byte of Heights with the height of a vertex. vertex: 0 to 8, but not the middle one, 4. */
CVERT_FUNCTION int latticeByte(int vertex) { return vertex < 4 ? vertex : vertex - 1; }

/*! Height of a vertex of the lattice, where planes cross, in bins. */
CVERT_FUNCTION int latticeHeight(Heights heights, int vertex) {
  if (vertex != 4) {
    int i = latticeByte(vertex);
    return int((i < 4 ? heights.low >> (8 * i) : heights.high >> (8 * i - 32)) & 127u);
  }
  uint32_t h = 0u;
  for (int i = 0; i < 4; i++) h |= ((heights.low >> (8 * i + 7)) & 1u) << i;
  for (int i = 0; i < 3; i++) h |= ((heights.high >> (8 * i + 7)) & 1u) << (i + 4);
  return int(h);
}

/* Word: per axis 5 bits each for the lower outer, upper outer and middle plane; then the thickness. */
CVERT_CONSTANT uint32_t latticePlaneMask = 31u;
CVERT_CONSTANT int latticeThicknessShift = 30;
CVERT_FUNCTION int latticeShift(int axis) { return 15 * axis; }

/*! Distance of an outer plane from the parent's, in parent extents: up to 0.36, for quads that do not fill their
 *  parent. Steps grow with the code, from 1/256; small distances compensate for rounding of the parent. */
CVERT_FUNCTION float latticeOuterOffset(uint32_t code) {
  return float(4u * code + code * code / 4u) * (1.0f / 1024.0f);
}

/*! Position of the middle plane, in parent extents: 33/128 to 95/128. Rounded to nearest: it bounds nothing. */
CVERT_FUNCTION float latticeMiddlePosition(uint32_t code) { return float(33u + 2u * code) * (1.0f / 128.0f); }

/*! Thickness in bins: 1, 2, 5 or 16. One bin covers the rounding of heights; the others cover the distance of straight
 *  edges from the lattice. */
CVERT_FUNCTION float latticeThickness(uint32_t code) { return float((0x10050201u >> (8u * code)) & 255u); }

/*! Plane 0 (lower), 1 (middle) or 2 (upper) on an axis of the frame. parent: box of the group. */
CVERT_FUNCTION float latticePlane(uint32_t word, int axis, int plane, NodeBox parent) {
  uint32_t bits = word >> latticeShift(axis);
  float at = plane == 0   ? latticeOuterOffset(bits & latticePlaneMask)
             : plane == 1 ? latticeMiddlePosition((bits >> 10) & latticePlaneMask)
                          : 1.0f - latticeOuterOffset((bits >> 5) & latticePlaneMask);
  return parent.lower[axis] + at * parent.extent[axis];
}

/* --- separate leaves ----------------------------------------------------------------- */

/* Heights: per child 5 bits each for corners (0,0), (1,0) and (0,1) of its box. The thickness begins at bit 60. */
CVERT_CONSTANT int separateLeafBits = 15;
CVERT_CONSTANT uint32_t separateLeafMask = 0x7FFFu;
CVERT_CONSTANT uint32_t solidLeaf = 0x7FFFu; //!< instead of heights: see LeafPatch
CVERT_CONSTANT uint32_t emptyLeaf = 0x7FFEu;
CVERT_CONSTANT int separateBins = 32;
CVERT_CONSTANT float separateRange = 2.0f; //!< range of heights, relative to the z extent of the leaf's box
CVERT_CONSTANT int separateThicknessShift = 60;
/*! Thickness in bins: 1, 1.5, 2, 3, 4, 6, 8 or 12. */
CVERT_FUNCTION float separateThickness(uint32_t code) {
  return 0.5f * float(packedByte(0x06040302u, 0x18100C08u, code));
}

/*! Heights of a child, solidLeaf or emptyLeaf. */
CVERT_FUNCTION uint32_t separateLeaf(Heights heights, int child) {
  int shift = separateLeafBits * child; // 0, 15, 30 or 45; the field at 30 is in both halves
  if (shift >= 32) return (heights.high >> (shift - 32)) & separateLeafMask;
  uint32_t bits = heights.low >> shift;
  if (shift != 0) bits |= heights.high << (32 - shift);
  return bits & separateLeafMask;
}

CVERT_FUNCTION int separateHeight(uint32_t leaf, int corner) { return int((leaf >> (5 * corner)) & 31u); }
CVERT_FUNCTION float separateThicknessOf(Heights heights) {
  return separateThickness((heights.high >> (separateThicknessShift - 32)) & 7u);
}

/* --- surfaces ------------------------------------------------------------------------ */

/*! Quantization of heights, with bins centered on a box. Height q is at z = lower + (q+1/2) size. */
struct HeightBins {
  float lower, size;
};

/*! range: extent of all bins, relative to the z extent of the box. */
CVERT_FUNCTION HeightBins heightBins(NodeBox box, float range, int count) {
  HeightBins bins;
  bins.lower = box.lower[2] - 0.5f * (range - 1.0f) * box.extent[2];
  bins.size = range / float(count) * box.extent[2];
  return bins;
}

CVERT_FUNCTION float zOfHeight(HeightBins bins, float height) { return bins.lower + (height + 0.5f) * bins.size; }

/*! A decoded leaf: a bilinear patch over a box, from which edges of quads deviate by half the thickness at most. */
struct LeafPatch {
  NodeBox box;
  float z[4];      //!< heights at the box's corners: column + 2 row; undefined if solid or empty
  float thickness; //!< in z; likewise
  bool solid;      //!< the box is the surface
  bool empty;      //!< there is no surface
};

CVERT_FUNCTION LeafPatch decodeSeparateLeaf(uint32_t word, Heights heights, int child, NodeBox parent) {
  LeafPatch leaf;
  leaf.box = decodeChild(word, child, parent);
  uint32_t code = separateLeaf(heights, child);
  leaf.solid = code == solidLeaf;
  leaf.empty = code == emptyLeaf;
  HeightBins bins = heightBins(leaf.box, separateRange, separateBins);
  for (int c = 0; c < 3; c++) leaf.z[c] = zOfHeight(bins, float(separateHeight(code, c)));
  leaf.z[3] = leaf.z[1] + leaf.z[2] - leaf.z[0];
  leaf.thickness = separateThicknessOf(heights) * bins.size;
  return leaf;
}

CVERT_FUNCTION LeafPatch decodeLatticeLeaf(uint32_t word, Heights heights, int child, NodeBox parent) {
  LeafPatch leaf;
  leaf.solid = false;
  leaf.empty = false;
  for (int axis = 0; axis < 2; axis++) {
    int coordinate = childCoordinate(child, axis);
    leaf.box.lower[axis] = latticePlane(word, axis, coordinate, parent);
    leaf.box.extent[axis] = latticePlane(word, axis, coordinate + 1, parent) - leaf.box.lower[axis];
  }
  HeightBins bins = heightBins(parent, latticeRange, latticeBins);
  leaf.thickness = latticeThickness(word >> latticeThicknessShift) * bins.size;
  float lowest = 1e30f, highest = -1e30f;
  for (int c = 0; c < 4; c++) {
    int vertex = childCoordinate(child, 0) + (c & 1) + 3 * (childCoordinate(child, 1) + (c >> 1));
    leaf.z[c] = zOfHeight(bins, float(latticeHeight(heights, vertex)));
    lowest = minimum(lowest, leaf.z[c]);
    highest = maximum(highest, leaf.z[c]);
  }
  /* a bilinear patch stays between its corners */
  float lower = maximum(lowest - 0.5f * leaf.thickness, parent.lower[2]);
  float upper = minimum(highest + 0.5f * leaf.thickness, upperOf(parent, 2));
  leaf.box.lower[2] = lower;
  leaf.box.extent[2] = upper > lower ? upper - lower : 0.0f;
  return leaf;
}

/*! child: column + 2 row. parent: decoded box of the group. */
CVERT_FUNCTION LeafPatch decodeLeaf(uint32_t word, Heights heights, int child, NodeBox parent) {
  if (hasSeparateLeaves(heights)) return decodeSeparateLeaf(word, heights, child, parent);
  return decodeLatticeLeaf(word, heights, child, parent);
}

CBVH_END

#endif
