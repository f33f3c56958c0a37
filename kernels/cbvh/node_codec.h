// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Inner nodes of a block: 32 bits hold the bounds of 4 children, relative to
 * the decoded bounds of their parent. The children are the 2 x 2 quadrants of
 * the parent's quads, in Morton order (child = column + 2 row).
 *
 *   column      0        1          Siblings share planes: both children of a
 *            |-----|  |-----|       column (row) have the same two x (y) planes,
 *            A     B  C     D       so 8 planes bound all four. A and D are the
 *       parent's x range            outer planes, B and C the inner ones; B and C
 *                                   overlap where the surface does.
 *
 * z has one interval a child, out of a book of 8.
 *
 * Decoding is lower + T * extent in float, T a multiple of 1/256: contracted to
 * a fused multiply-add or not, one step is off by at most one ulp of a number
 * below 2, so after 8 levels by less than 2^-20. The encoder keeps every decoded
 * plane at least containmentSlack away from the geometry, therefore bounds
 * contain it on every ISA, whatever the compiler contracts.
 *
 * Based on: Selgrad et al., "A Compressed Representation for Ray Tracing
 * Parametric Surfaces", 2016 (relative bounds, shared planes). */

#include "target.h"
#include <cstdint>

namespace embree
{
  namespace cbvh { inline namespace CBVH_TARGET
  {
    /*! bounds in the block's frame, where the block's own box is [0,1]^3 */
    struct NodeBox
    {
      float lower[3];
      float extent[3];

      static NodeBox root() { return {{0.0f,0.0f,0.0f},{1.0f,1.0f,1.0f}}; }
      float upper(int axis) const { return lower[axis] + extent[axis]; }
    };

    /*! exact bounds of geometry; double, as the encoder must not round inwards */
    struct ExactBox
    {
      double lower[3] = { 1e300, 1e300, 1e300 };
      double upper[3] = {-1e300,-1e300,-1e300 };

      bool empty() const { return lower[0] > upper[0]; }

      void extend(const double p[3]) {
        for (int i=0; i<3; i++) {
          lower[i] = p[i] < lower[i] ? p[i] : lower[i];
          upper[i] = p[i] > upper[i] ? p[i] : upper[i];
        }
      }

      void extend(const ExactBox& b) {
        for (int i=0; i<3; i++) {
          lower[i] = b.lower[i] < lower[i] ? b.lower[i] : lower[i];
          upper[i] = b.upper[i] > upper[i] ? b.upper[i] : upper[i];
        }
      }
    };

    /*! distance that decoded planes keep from the geometry, see above */
    static constexpr double containmentSlack = 1.0/(1<<20);

    /*! Outer planes: distance from the parent's plane, in parent extents. They
     *  only win back what the parent's own rounding lost, hence small steps. */
    static constexpr float outerOffsets[4] = { 0.0f, 6.0f/256, 16.0f/256, 36.0f/256 };

    /*! Inner planes: position of column 0's upper plane; column 1's lower plane
     *  mirrors it. Fine around the middle, where patch-aligned frames put it, and
     *  1 for surfaces that fold over their neighbour. */
    static constexpr float innerPositions[8] = { 116.0f/256, 125.0f/256, 130.0f/256, 136.0f/256, 144.0f/256, 160.0f/256, 192.0f/256, 1.0f };

    /*! z intervals in parent extents; the first one always contains. The others make
     *  the mean logarithm of a child's height smallest over blocks of real and of
     *  analytic displacements: 8% less a level than halves and quarters. */
    struct Interval { float lower, upper; };
    static constexpr Interval zIntervals[8] = {
      { 0.0f, 1.0f },         { 0.21875f, 0.8125f },  { 0.0625f, 0.625f }, { 0.5f, 1.0f },
      { 0.34375f, 0.71875f }, { 0.21875f, 0.59375f }, { 0.4375f, 0.875f }, { 0.0f, 0.46875f }
    };

    /*! Bit layout of a node. A plane pair is 5 bits: 2 for the outer plane, then
     *  3 for the inner one.
     *
     *    bits  0..4   x lower planes of columns 0 (outer) and 1 (inner)
     *    bits  5..9   x upper planes of columns 1 (outer) and 0 (inner)
     *    bits 10..14  y lower planes of rows 0 and 1
     *    bits 15..19  y upper planes of rows 1 and 0
     *    bits 20..31  z interval of children 0 to 3, 3 bits each */
    static constexpr int planePairBits = 5;
    static constexpr uint32_t planePairMask = 31;
    static constexpr int zShift = 20;
    static constexpr int zBits = 3;

    constexpr int lowerShift(int axis) { return axis*2*planePairBits; }
    constexpr int upperShift(int axis) { return axis*2*planePairBits + planePairBits; }

    /*! lower (upper) plane of a column, in parent extents, from the 5 bits of its pair */
    constexpr float lowerPlane(uint32_t pair, int column) {
      return column == 0 ? outerOffsets[pair & 3] : 1.0f - innerPositions[(pair >> 2) & 7];
    }
    constexpr float upperPlane(uint32_t pair, int column) {
      return column == 1 ? 1.0f - outerOffsets[pair & 3] : innerPositions[(pair >> 2) & 7];
    }

    inline int childColumn(int child, int axis) { return (child >> axis) & 1; }

    inline uint32_t zCode(uint32_t node, int child) { return (node >> (zShift + zBits*child)) & 7; }

    /*! scalar reference decoder */
    inline NodeBox decodeChild(uint32_t node, int child, const NodeBox& parent)
    {
      NodeBox box;
      for (int axis=0; axis<2; axis++) {
        const int column = childColumn(child,axis);
        const float lower = parent.lower[axis] + lowerPlane((node >> lowerShift(axis)) & planePairMask, column)*parent.extent[axis];
        const float upper = parent.lower[axis] + upperPlane((node >> upperShift(axis)) & planePairMask, column)*parent.extent[axis];
        box.lower[axis] = lower;
        box.extent[axis] = upper - lower;
      }
      const Interval z = zIntervals[zCode(node,child)];
      const float lower = parent.lower[2] + z.lower*parent.extent[2];
      const float upper = parent.lower[2] + z.upper*parent.extent[2];
      box.lower[2] = lower;
      box.extent[2] = upper - lower;
      return box;
    }

    /*! whether a plane pair's code keeps the slack to both columns; codes that mean
     *  "the parent's plane" do so by the parent's own containment */
    inline uint32_t encodeLowerPair(const NodeBox& parent, int axis, double outer, double inner)
    {
      uint32_t o = 0, i = 7;
      for (uint32_t q=1; q<4; q++)
        if (parent.lower[axis] + outerOffsets[q]*parent.extent[axis] <= outer - containmentSlack) o = q;
      for (int q=6; q>=0; q--)
        if (parent.lower[axis] + (1.0f-innerPositions[q])*parent.extent[axis] <= inner - containmentSlack) i = uint32_t(q);
      return o | (i << 2);
    }

    inline uint32_t encodeUpperPair(const NodeBox& parent, int axis, double outer, double inner)
    {
      uint32_t o = 0, i = 7;
      for (uint32_t q=1; q<4; q++)
        if (parent.lower[axis] + (1.0f-outerOffsets[q])*parent.extent[axis] >= outer + containmentSlack) o = q;
      for (int q=6; q>=0; q--)
        if (parent.lower[axis] + innerPositions[q]*parent.extent[axis] >= inner + containmentSlack) i = uint32_t(q);
      return o | (i << 2);
    }

    /*! Encodes the bounds of four children. A child without geometry may have any
     *  bounds. Precondition: parent contains all children with the slack. */
    inline uint32_t encodeNode(const NodeBox& parent, const ExactBox children[4])
    {
      uint32_t node = 0;
      for (int axis=0; axis<2; axis++)
      {
        ExactBox column[2];
        for (int c=0; c<4; c++)
          column[childColumn(c,axis)].extend(children[c]);
        node |= encodeLowerPair(parent,axis,column[0].lower[axis],column[1].lower[axis]) << lowerShift(axis);
        node |= encodeUpperPair(parent,axis,column[1].upper[axis],column[0].upper[axis]) << upperShift(axis);
      }
      for (int c=0; c<4; c++)
      {
        uint32_t best = 0;
        for (uint32_t q=1; q<8; q++) {
          const bool contains =
            parent.lower[2] + zIntervals[q].lower*parent.extent[2] <= children[c].lower[2] - containmentSlack &&
            parent.lower[2] + zIntervals[q].upper*parent.extent[2] >= children[c].upper[2] + containmentSlack;
          if (contains && zIntervals[q].upper-zIntervals[q].lower < zIntervals[best].upper-zIntervals[best].lower) best = q;
        }
        node |= best << (zShift + zBits*c);
      }
      return node;
    }
  }}
}
