// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes node words (node.h). Compares planes decoded in float with exact bounds in double, so that no plane is
 * rounded inwards. */

#include "node.h"
#include "../base/codec_names.h"
#include "../../cvert/portable/double4.h"
#include <algorithm>

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Bounds in the frame, not rounded, padded to full lanes. Initially empty. */
struct ExactBox {
  double lower[4] = {1e300, 1e300, 1e300, 1e300};
  double upper[4] = {-1e300, -1e300, -1e300, -1e300};

  ExactBox() {}
  ExactBox(Double4 l, Double4 u) {
    l.store(lower);
    u.store(upper);
  }

  bool empty() const { return lower[0] > upper[0]; }

  void extend(const double p[3]) {
    for (int i = 0; i < 3; i++) {
      lower[i] = p[i] < lower[i] ? p[i] : lower[i];
      upper[i] = p[i] > upper[i] ? p[i] : upper[i];
    }
  }

  void extend(const ExactBox& b) {
    min(Double4::load(lower), Double4::load(b.lower)).store(lower);
    max(Double4::load(upper), Double4::load(b.upper)).store(upper);
  }
};

/* The codebooks of node.h, one code per lane: all outer codes, and four inner ones. */
inline Float4 outerOffsets() { return Float4(outerOffset(0), outerOffset(1), outerOffset(2), outerOffset(3)); }
inline Float4 innerPositions(uint32_t first) {
  return Float4(innerPosition(first), innerPosition(first + 1), innerPosition(first + 2), innerPosition(first + 3));
}

inline uint32_t lowestBit(uint32_t bits) { return uint32_t(__builtin_ctz(bits)); }
inline uint32_t highestBit(uint32_t bits) { return 31u - uint32_t(__builtin_clz(bits)); }

/*! Returns the tightest plane pair: the highest outer and the lowest inner code. outer, inner: masks of the codes
 *  whose planes contain the children. Outer code 0 and inner code 7, the parent's planes, always do. */
inline uint32_t makePlanePair(uint32_t outer, uint32_t inner) {
  return highestBit(outer | 1) | (lowestBit(inner | 1u << 7) << 2);
}

/*! Returns the codes of the highest lower planes that keep containmentSlack from the children. lower, extent: of
 *  the parent. outer, inner: exact lower bounds of columns (or rows) 0 and 1. */
inline uint32_t encodeLowerPair(float lower, float extent, double outer, double inner) {
  const Float4 l = lower, e = extent;
  const Double4 o = outer - containmentSlack, i = inner - containmentSlack;
  return makePlanePair((Double4(l + outerOffsets() * e) <= o).bits(),
                       (Double4(l + (Float4(1.0f) - innerPositions(0)) * e) <= i).bits() |
                           (Double4(l + (Float4(1.0f) - innerPositions(4)) * e) <= i).bits() << 4);
}

/*! As above, for the lowest upper planes. outer, inner: exact upper bounds of columns (or rows) 1 and 0. */
inline uint32_t encodeUpperPair(float lower, float extent, double outer, double inner) {
  const Float4 l = lower, e = extent;
  const Double4 o = outer + containmentSlack, i = inner + containmentSlack;
  return makePlanePair((o <= Double4(l + (Float4(1.0f) - outerOffsets()) * e)).bits(),
                       (i <= Double4(l + innerPositions(0) * e)).bits() |
                           (i <= Double4(l + innerPositions(4) * e)).bits() << 4);
}

/*! The eight z intervals in a parent, from the smallest to the largest. */
class ZIntervals {
public:
  ZIntervals(const NodeBox& parent) {
    const Float4 l = parent.lower[2], e = parent.extent[2];
    const Interval a = zInterval(4), b = zInterval(5), c = zInterval(6), d = zInterval(7), f = zInterval(3),
                   g = zInterval(2), h = zInterval(1), all = zInterval(0);
    lower[0] = l + Float4(a.lower, b.lower, c.lower, d.lower) * e;
    lower[1] = l + Float4(f.lower, g.lower, h.lower, all.lower) * e;
    upper[0] = l + Float4(a.upper, b.upper, c.upper, d.upper) * e;
    upper[1] = l + Float4(f.upper, g.upper, h.upper, all.upper) * e;
  }

  /*! Code of the smallest interval that contains a child with the slack. Interval 0 always does. */
  uint32_t smallest(double childLower, double childUpper) const {
    const Double4 l = childLower - containmentSlack, u = childUpper + containmentSlack;
    uint32_t contains = 1u << 7;
    for (int i = 0; i < 2; i++) contains |= ((lower[i] <= l) & (u <= upper[i])).bits() << (4 * i);
    // 4 bits per lane: its code
    return (0x01237654u >> (4 * lowestBit(contains))) & 7u;
  }

private:
  Double4 lower[2], upper[2]; //!< of codes 4, 5, 6 and 7; of 3, 2, 1 and 0
};

/*! Returns the word of a node. parent: its decoded box, which must contain all children with containmentSlack.
 *  Empty children get arbitrary bounds. */
inline uint32_t encodeNode(const NodeBox& parent, const ExactBox children[4]) {
  uint32_t node = 0;
  for (int axis = 0; axis < 2; axis++) {
    /* a, b: in column (row) 0. c, d: in column (row) 1. */
    const ExactBox &a = children[0], &b = children[2 >> axis], &c = children[1 << axis], &d = children[3];
    const float l = parent.lower[axis], e = parent.extent[axis];
    node |= encodeLowerPair(l, e, std::min(a.lower[axis], b.lower[axis]), std::min(c.lower[axis], d.lower[axis]))
            << lowerShift(axis);
    node |= encodeUpperPair(l, e, std::max(c.upper[axis], d.upper[axis]), std::max(a.upper[axis], b.upper[axis]))
            << upperShift(axis);
  }
  const ZIntervals intervals(parent);
  for (int c = 0; c < 4; c++)
    node |= intervals.smallest(children[c].lower[2], children[c].upper[2]) << (zShift + zBits * c);
  return node;
}

/*! The boxes of a node's children, as decodeChild() returns them. */
struct NodeBoxes {
  float lower[3][4], extent[3][4];

  NodeBoxes() {}
  NodeBoxes(uint32_t word, const NodeBox& parent) {
    for (int axis = 0; axis < 2; axis++) {
      const uint32_t l = word >> lowerShift(axis) & planePairMask, u = word >> upperShift(axis) & planePairMask;
      const float l0 = lowerPlane(l, 0), l1 = lowerPlane(l, 1), u0 = upperPlane(u, 0), u1 = upperPlane(u, 1);
      set(axis, parent, axis == 0 ? Float4(l0, l1, l0, l1) : Float4(l0, l0, l1, l1),
          axis == 0 ? Float4(u0, u1, u0, u1) : Float4(u0, u0, u1, u1));
    }
    const Interval z[4] = {zInterval(zCode(word, 0)), zInterval(zCode(word, 1)), zInterval(zCode(word, 2)),
                           zInterval(zCode(word, 3))};
    set(2, parent, Float4(z[0].lower, z[1].lower, z[2].lower, z[3].lower),
        Float4(z[0].upper, z[1].upper, z[2].upper, z[3].upper));
  }

  NodeBox operator[](uint32_t c) const {
    return {{lower[0][c], lower[1][c], lower[2][c]}, {extent[0][c], extent[1][c], extent[2][c]}};
  }

private:
  /*! lowerPlanes, upperPlanes: of the children, in parent extents. */
  void set(int axis, const NodeBox& parent, Float4 lowerPlanes, Float4 upperPlanes) {
    const Float4 l = Float4(parent.lower[axis]) + lowerPlanes * parent.extent[axis],
                 u = Float4(parent.lower[axis]) + upperPlanes * parent.extent[axis];
    l.store(lower[axis]);
    (u - l).store(extent[axis]);
  }
};
}} // namespace embree::cbvh::CBVH_ISA
