// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of node words, codec/node.h. In double, as it must not round inwards. */

#include "../codec/node.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    /*! exact bounds of geometry */
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

    /*! Code of the lower planes of both columns: the highest that keep the slack to them. The
     *  code 0 means the parent's plane, which keeps it already. */
    inline uint32_t encodeLowerPair(const NodeBox& parent, int axis, double outer, double inner)
    {
      uint32_t o = 0, i = 7;
      for (uint32_t q=1; q<4; q++)
        if (parent.lower[axis] + outerOffset(q)*parent.extent[axis] <= outer - containmentSlack) o = q;
      for (int q=6; q>=0; q--)
        if (parent.lower[axis] + (1.0f-innerPosition(uint32_t(q)))*parent.extent[axis] <= inner - containmentSlack) i = uint32_t(q);
      return o | (i << 2);
    }

    /*! the same for the upper planes */
    inline uint32_t encodeUpperPair(const NodeBox& parent, int axis, double outer, double inner)
    {
      uint32_t o = 0, i = 7;
      for (uint32_t q=1; q<4; q++)
        if (parent.lower[axis] + (1.0f-outerOffset(q))*parent.extent[axis] >= outer + containmentSlack) o = q;
      for (int q=6; q>=0; q--)
        if (parent.lower[axis] + innerPosition(uint32_t(q))*parent.extent[axis] >= inner + containmentSlack) i = uint32_t(q);
      return o | (i << 2);
    }

    /*! code of the smallest z interval that contains a child */
    inline uint32_t encodeInterval(const NodeBox& parent, const ExactBox& child)
    {
      uint32_t best = 0;
      float smallest = 1.0f;
      for (uint32_t q=1; q<8; q++) {
        const Interval z = zInterval(q);
        const bool contains =
          parent.lower[2] + z.lower*parent.extent[2] <= child.lower[2] - containmentSlack &&
          parent.lower[2] + z.upper*parent.extent[2] >= child.upper[2] + containmentSlack;
        if (contains && z.upper-z.lower < smallest) { best = q; smallest = z.upper-z.lower; }
      }
      return best;
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
        node |= encodeInterval(parent,children[c]) << (zShift + zBits*c);
      return node;
    }
  }}
}
