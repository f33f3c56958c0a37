// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cLEAF: groups of 2 x 2 quads. A group has one node word, as the nodes of
 * the last level, and 64 bits of heights: 2 bytes and 8 bits a quad.
 *
 * Lattice. Nine heights over three planes of x and three of y: one bilinear patch a
 * quad, and patches that share their edges.
 *
 *    y2 +-------+--------+   x0, x2, y0, y2 bound the group's quads; x1 and y1 run
 *       |   2   |    3   |   along its middle column and row of vertices. The surface
 *    y1 +-------+--------+   passes through the quads' vertices, wherever in their
 *       |   0   |    1   |   cells they are. Siblings do not overlap and have no steps
 *    y0 +-------+--------+   between them.
 *       x0     x1       x2
 *
 * Loose. Where quads fold over each other, or have holes: a node word like any
 * other, and in each child's box a plane of its own, or the whole box (solid), or
 * nothing (empty).
 *
 * Either way a leaf's surface bounds the edges of its quad to half a thickness, up and
 * down in z.
 *
 * Based on: Lier et al., "A High-Resolution Compression Scheme for Ray Tracing
 * Subdivision Surfaces with Displacement", 2018, section 4.1, which stores each
 * corner of each quad, in 4 bits. */

#include "node_codec.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_TARGET
  {
    /*! Bits of the heights. Byte i holds in its lower 7 bits the height of vertex i
     *  of the lattice, row by row without the middle one; the upper bits of bytes 0
     *  to 6 are the middle one's, that of byte 7 says loose. */
    inline bool isLoose(uint64_t heights) { return heights >> 63; }

    static constexpr int latticeBins = 128;
    static constexpr float latticeRange = 1.5f; //!< of the bins, in heights of the parent's box: patches are extrapolated to the corners

    inline int latticeByte(int vertex) { return vertex < 4 ? vertex : vertex-1; }

    inline int latticeHeight(uint64_t heights, int vertex)
    {
      if (vertex != 4) return int(heights >> (8*latticeByte(vertex))) & 127;
      int h = 0;
      for (int i=0; i<7; i++) h |= int((heights >> (8*i+7)) & 1) << i;
      return h;
    }

    inline uint64_t packLattice(const int heights[9])
    {
      uint64_t bits = 0;
      for (int v=0; v<9; v++)
        if (v != 4) bits |= uint64_t(heights[v]) << (8*latticeByte(v));
      for (int i=0; i<7; i++) bits |= uint64_t((heights[4] >> i) & 1) << (8*i+7);
      return bits;
    }

    /*! Word of a lattice: 15 bits an axis, of 5 bits each the outer planes' distances
     *  from the parent's, lower and upper, and the middle plane; then the thickness. */
    static constexpr uint32_t latticePlaneMask = 31;
    constexpr int latticeShift(int axis) { return 15*axis; }
    constexpr int latticeThicknessShift = 30;

    /*! outer planes, in parent extents: fine steps for what the parent's own rounding
     *  lost, up to a third for quads that do not fill their parent */
    constexpr float latticeOuter(uint32_t code) { return float(4*code + code*code/4)*(1.0f/1024); }

    /*! the middle plane bounds nothing, it is the nearest */
    constexpr float latticeMiddle(uint32_t code) { return float(33 + 2*code)*(1.0f/128); }

    /*! thickness in bins: heights are rounded by up to half a bin either way, the rest
     *  is how far edges are from straight over the lattice */
    static constexpr float latticeThickness[4] = { 1.0f, 2.0f, 5.0f, 16.0f };

    /*! Loose heights: 15 bits a child, 5 bits each for corners (0,0), (1,0) and (0,1)
     *  of its box, and from bit 60 the thickness. */
    static constexpr int looseBits = 15;
    static constexpr uint32_t looseMask = 0x7FFF;
    static constexpr uint32_t solidLeaf = 0x7FFF;
    static constexpr uint32_t emptyLeaf = 0x7FFE;
    static constexpr int looseBins = 32;
    static constexpr float looseRange = 2.0f; //!< of the bins, in heights of the leaf's box
    static constexpr int looseThicknessShift = 60;
    static constexpr float looseThickness[8] = { 1.0f, 1.5f, 2.0f, 3.0f, 4.0f, 6.0f, 8.0f, 12.0f };

    inline uint32_t looseLeaf(uint64_t heights, int child) { return uint32_t(heights >> (looseBits*child)) & looseMask; }
    inline int looseHeight(uint32_t leaf, int corner) { return int(leaf >> (5*corner)) & 31; }

    /*! bins of heights: the range is centred on the box, height q is at lower + (q+1/2) size */
    struct HeightBins
    {
      float lower, size;
      HeightBins(const NodeBox& box, float range, int bins)
        : lower(box.lower[2] - 0.5f*(range-1.0f)*box.extent[2]), size(range/float(bins)*box.extent[2]) {}
      float z(float height) const { return lower + (height+0.5f)*size; }
    };

    inline float bilinear(const float c[4], float u, float v) {
      return c[0] + u*(c[1]-c[0]) + v*(c[2]-c[0]) + u*v*(c[0]-c[1]-c[2]+c[3]);
    }

    /*! a leaf: its box, and the surface in it */
    struct LeafPatch
    {
      NodeBox box;
      float z[4];       //!< at the corners of the box, column + 2 row
      float thickness;
      bool solid, empty;
    };

    /*! planes of a lattice along one axis */
    inline void latticePlanes(uint32_t word, int axis, const NodeBox& parent, float planes[3])
    {
      const uint32_t bits = word >> latticeShift(axis);
      planes[0] = parent.lower[axis] + latticeOuter(bits & latticePlaneMask)*parent.extent[axis];
      planes[1] = parent.lower[axis] + latticeMiddle((bits >> 10) & latticePlaneMask)*parent.extent[axis];
      planes[2] = parent.lower[axis] + (1.0f-latticeOuter((bits >> 5) & latticePlaneMask))*parent.extent[axis];
    }

    /*! scalar reference decoder */
    inline LeafPatch decodeLeaf(uint32_t word, uint64_t heights, int child, const NodeBox& parent)
    {
      LeafPatch leaf;
      leaf.solid = leaf.empty = false;
      if (isLoose(heights))
      {
        leaf.box = decodeChild(word,child,parent);
        const uint32_t code = looseLeaf(heights,child);
        leaf.solid = code == solidLeaf;
        leaf.empty = code == emptyLeaf;
        const HeightBins bins(leaf.box,looseRange,looseBins);
        for (int c=0; c<3; c++) leaf.z[c] = bins.z(float(looseHeight(code,c)));
        leaf.z[3] = leaf.z[1]+leaf.z[2]-leaf.z[0];
        leaf.thickness = looseThickness[(heights >> looseThicknessShift) & 7]*bins.size;
        return leaf;
      }
      for (int axis=0; axis<2; axis++) {
        float planes[3];
        latticePlanes(word,axis,parent,planes);
        const int column = childColumn(child,axis);
        leaf.box.lower[axis] = planes[column];
        leaf.box.extent[axis] = planes[column+1]-planes[column];
      }
      const HeightBins bins(parent,latticeRange,latticeBins);
      leaf.thickness = latticeThickness[word >> latticeThicknessShift]*bins.size;
      float lowest = 1e30f, highest = -1e30f;
      for (int c=0; c<4; c++) {
        const int vertex = childColumn(child,0)+(c&1) + 3*(childColumn(child,1)+(c>>1));
        leaf.z[c] = bins.z(float(latticeHeight(heights,vertex)));
        lowest  = leaf.z[c] < lowest  ? leaf.z[c] : lowest;
        highest = leaf.z[c] > highest ? leaf.z[c] : highest;
      }
      /* a bilinear patch stays between its corners */
      const float z0 = lowest-0.5f*leaf.thickness, z1 = highest+0.5f*leaf.thickness;
      const float lower = z0 > parent.lower[2] ? z0 : parent.lower[2];
      const float upper = z1 < parent.upper(2) ? z1 : parent.upper(2);
      leaf.box.lower[2] = lower;
      leaf.box.extent[2] = upper > lower ? upper-lower : 0.0f;
      return leaf;
    }
  }}
}
