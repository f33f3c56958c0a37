// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cLEAF stores groups of 2 x 2 leaves: a word, in place of a node of the last level, and 64 bits of heights.
 *
 * Lattice: nine heights over three planes of x and three of y. Each leaf is a bilinear patch, which shares edges with
 * adjacent patches.
 *
 *    y2 +-------+--------+   x0, x2, y0, y2 bound the group's quads; x1 and y1 run
 *       |   2   |    3   |   along its middle column and row of vertices. The surface
 *    y1 +-------+--------+   passes through the quads' vertices, wherever in their
 *       |   0   |    1   |   cells they are. Siblings do not overlap and have no steps
 *    y0 +-------+--------+   between them.
 *       x0     x1       x2
 *
 * Loose: for quads that fold over each other or have holes. The word is a node's. Each child's box contains its own
 * plane, is solid, or is empty.
 *
 * In both forms, a leaf's surface, widened by half a thickness up and down in z, contains its quad's edges.
 *
 * Based on: Lier et al., "A High-Resolution Compression Scheme for Ray Tracing Subdivision Surfaces with Displacement",
 * 2018, section 4.1, which stores each corner of each quad in 4 bits. */

#ifndef CBVH_LEAF_H
#define CBVH_LEAF_H

#include "../node.h"

CBVH_BEGIN

/*! Lattice: the lower 7 bits of byte i are the height of vertex i, row by row without the middle one. The upper bits of
 *  bytes 0 to 6 are the height of the middle vertex. The upper bit of byte 7 is set for loose groups. */
struct Heights
{
  uint32_t low;   //!< bytes 0 to 3
  uint32_t high;  //!< bytes 4 to 7
};

CBVH_FUNCTION bool isLoose (Heights heights) { return (heights.high >> 31) != 0u; }

/* --- lattices ------------------------------------------------------------------------ */

CVERT_CONSTANT int latticeBins = 128;
/*! In heights of the parent's box. Exceeds 1, because patches are extrapolated to the corners. */
CVERT_CONSTANT float latticeRange = 1.5f;

CBVH_FUNCTION int latticeByte (int vertex) { return vertex < 4 ? vertex : vertex-1; }

CBVH_FUNCTION int latticeHeight (Heights heights, int vertex)
{
  if (vertex != 4) {
    int i = latticeByte(vertex);
    return int((i < 4 ? heights.low >> (8*i) : heights.high >> (8*i-32)) & 127u);
  }
  uint32_t h = 0u;
  for (int i=0; i<4; i++) h |= ((heights.low >> (8*i+7)) & 1u) << i;
  for (int i=0; i<3; i++) h |= ((heights.high >> (8*i+7)) & 1u) << (i+4);
  return int(h);
}

/* Word: per axis 5 bits each for the lower outer, upper outer and middle plane; then the thickness. */
CVERT_CONSTANT uint32_t latticePlaneMask = 31u;
CVERT_CONSTANT int latticeThicknessShift = 30;
CBVH_FUNCTION int latticeShift (int axis) { return 15*axis; }

/*! Distance of an outer plane from the parent's, in parent extents. Fine steps compensate for rounding of the parent.
 *  Codes extend to a third, for quads that do not fill their parent. */
CBVH_FUNCTION float latticeOuter (uint32_t code) { return float(4u*code + code*code/4u)*(1.0f/1024.0f); }

/*! The middle plane bounds nothing, so it is rounded to nearest. */
CBVH_FUNCTION float latticeMiddle (uint32_t code) { return float(33u + 2u*code)*(1.0f/128.0f); }

/*! In bins: 1, 2, 5 or 16. Heights are rounded by up to half a bin; the rest is the distance of straight edges from the
 *  lattice. */
CBVH_FUNCTION float latticeThickness (uint32_t code) { return float((0x10050201u >> (8u*code)) & 255u); }

/*! Plane 0, 1 or 2 along an axis. */
CBVH_FUNCTION float latticePlane (uint32_t word, int axis, int plane, NodeBox parent)
{
  uint32_t bits = word >> latticeShift(axis);
  float at = plane == 0 ? latticeOuter(bits & latticePlaneMask)
           : plane == 1 ? latticeMiddle((bits >> 10) & latticePlaneMask)
           : 1.0f-latticeOuter((bits >> 5) & latticePlaneMask);
  return parent.lower[axis] + at*parent.extent[axis];
}

/* --- loose leaves -------------------------------------------------------------------- */

/* Heights: per child 5 bits each for corners (0,0), (1,0) and (0,1) of its box. The thickness begins at bit 60. */
CVERT_CONSTANT int looseBits = 15;
CVERT_CONSTANT uint32_t looseMask = 0x7FFFu;
CVERT_CONSTANT uint32_t solidLeaf = 0x7FFFu;
CVERT_CONSTANT uint32_t emptyLeaf = 0x7FFEu;
CVERT_CONSTANT int looseBins = 32;
CVERT_CONSTANT float looseRange = 2.0f; //!< in heights of the leaf's box
CVERT_CONSTANT int looseThicknessShift = 60;
/*! In bins: 1, 1.5, 2, 3, 4, 6, 8 or 12. */
CBVH_FUNCTION float looseThickness (uint32_t code) { return 0.5f*float(packedByte(0x06040302u,0x18100C08u,code)); }

CBVH_FUNCTION uint32_t looseLeaf (Heights heights, int child)
{
  int shift = looseBits*child; // 0, 15, 30 or 45; the field at 30 is in both halves
  if (shift >= 32) return (heights.high >> (shift-32)) & looseMask;
  uint32_t bits = heights.low >> shift;
  if (shift != 0) bits |= heights.high << (32-shift);
  return bits & looseMask;
}

CBVH_FUNCTION int looseHeight (uint32_t leaf, int corner) { return int((leaf >> (5*corner)) & 31u); }
CBVH_FUNCTION float looseThicknessOf (Heights heights) {
  return looseThickness((heights.high >> (looseThicknessShift-32)) & 7u);
}

/* --- surfaces ------------------------------------------------------------------------ */

/*! Centered on the box. Height q is at lower + (q+1/2) size. */
struct HeightBins { float lower, size; };

CBVH_FUNCTION HeightBins heightBins (NodeBox box, float range, int count)
{
  HeightBins bins;
  bins.lower = box.lower[2] - 0.5f*(range-1.0f)*box.extent[2];
  bins.size = range/float(count)*box.extent[2];
  return bins;
}

CBVH_FUNCTION float heightInBins (HeightBins bins, float height) { return bins.lower + (height+0.5f)*bins.size; }

struct LeafPatch
{
  NodeBox box;
  float z[4];       //!< at the box's corners: column + 2 row
  float thickness;
  bool solid;       //!< the box is the surface
  bool empty;
};

CBVH_FUNCTION LeafPatch decodeLooseLeaf (uint32_t word, Heights heights, int child, NodeBox parent)
{
  LeafPatch leaf;
  leaf.box = decodeChild(word,child,parent);
  uint32_t code = looseLeaf(heights,child);
  leaf.solid = code == solidLeaf;
  leaf.empty = code == emptyLeaf;
  HeightBins bins = heightBins(leaf.box,looseRange,looseBins);
  for (int c=0; c<3; c++) leaf.z[c] = heightInBins(bins,float(looseHeight(code,c)));
  leaf.z[3] = leaf.z[1]+leaf.z[2]-leaf.z[0];
  leaf.thickness = looseThicknessOf(heights)*bins.size;
  return leaf;
}

CBVH_FUNCTION LeafPatch decodeLatticeLeaf (uint32_t word, Heights heights, int child, NodeBox parent)
{
  LeafPatch leaf;
  leaf.solid = false;
  leaf.empty = false;
  for (int axis=0; axis<2; axis++) {
    int column = childColumn(child,axis);
    leaf.box.lower[axis] = latticePlane(word,axis,column,parent);
    leaf.box.extent[axis] = latticePlane(word,axis,column+1,parent)-leaf.box.lower[axis];
  }
  HeightBins bins = heightBins(parent,latticeRange,latticeBins);
  leaf.thickness = latticeThickness(word >> latticeThicknessShift)*bins.size;
  float lowest = 1e30f, highest = -1e30f;
  for (int c=0; c<4; c++) {
    int vertex = childColumn(child,0)+(c&1) + 3*(childColumn(child,1)+(c>>1));
    leaf.z[c] = heightInBins(bins,float(latticeHeight(heights,vertex)));
    lowest = lesser(lowest,leaf.z[c]);
    highest = greater(highest,leaf.z[c]);
  }
  /* a bilinear patch stays between its corners */
  float lower = greater(lowest-0.5f*leaf.thickness,parent.lower[2]);
  float upper = lesser(highest+0.5f*leaf.thickness,upperOf(parent,2));
  leaf.box.lower[2] = lower;
  leaf.box.extent[2] = upper > lower ? upper-lower : 0.0f;
  return leaf;
}

CBVH_FUNCTION LeafPatch decodeLeaf (uint32_t word, Heights heights, int child, NodeBox parent)
{
  if (isLoose(heights)) return decodeLooseLeaf(word,heights,child,parent);
  return decodeLatticeLeaf(word,heights,child,parent);
}

CBVH_END

#endif
