// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* How a ray crosses a leaf of cLEAF: input of hit_rule.h, and positions of hits. The ray's height above a bilinear
 * patch is a parabola in s. Compiles as C++ and GLSL; crossing1.h and visitorK.h are the SIMD versions. */

#ifndef CBVH_PAPER_LEAF_CROSSING_H
#define CBVH_PAPER_LEAF_CROSSING_H

#include "format.h"
#include "../local_ray.h"
#include "hit_rule.h"

CBVH_BEGIN

/*! Height of the ray above the patch: f(k) = f0 + k (f1-f0) + saddle k (1-k). k is 0 where the ray enters the leaf's
 *  box, 1 where it leaves. */
CVERT_REAL struct Parabola {
  Real f0, f1, saddle;
};

CVERT_REAL CVERT_FUNCTION Real parabolaAt(CVERT_OF(Parabola) f, Real k) {
  return f.f0 + k * (f.f1 - f.f0) + f.saddle * k * (Real(1) - k);
}

/*! Returns the k at which f changes sign, or the end nearer to the patch if the signs at both ends are the same. */
CVERT_REAL CVERT_FUNCTION Real parabolaRoot(CVERT_OF(Parabola) f) {
  if ((f.f0 < Real(0)) == (f.f1 < Real(0))) return magnitude(f.f0) < magnitude(f.f1) ? Real(0) : Real(1);
  /* Solves saddle k^2 - b k - f0 = 0. The sum in q cannot cancel. A root is in [0,1]; both may be if f0 or f1 is 0. */
  Real b = f.f1 - f.f0 + f.saddle;
  Real d = squareRoot(maximum(b * b + Real(4) * f.saddle * f.f0, Real(0)));
  Real q = Real(0.5f) * (b + (b < Real(0) ? -d : d));
  if (q == Real(0)) return Real(0);                                          // b, d and f0 are 0
  Real k = -f.f0 / q, clamped = k > Real(0) ? minimum(k, Real(1)) : Real(0); // a number even if k is NaN
  if (k == clamped || f.saddle == Real(0)) return clamped;
  /* rounding can move either root out of [0,1] */
  Real other = q / f.saddle, otherClamped = clampToUnit(other);
  return magnitude(k - clamped) <= magnitude(other - otherClamped) ? clamped : otherClamped;
}

/*! The lip of a block's side, see hit_rule.h: up to `depth` below the patch, within `width` of the side, a fraction of
 *  the leaf's box. epsilon: z component of the ray's epsilon, see local_ray.h. */
CVERT_REAL struct Lip {
  Real width, depth, epsilon;
};

CVERT_REAL struct LipIntersection {
  bool hit;
  /*! If hit: the first k that is in the lip, tested in this order: entry into the lip's width, exit from it, vertex of
   *  f. The entry if none is. */
  Real k;
};

/*! p0, p1: distance of the ray from the side at entry and exit, in fractions of the box. Within the lip's width, f has
 *  its extremes at both ends or at the parabola's vertex. */
CVERT_REAL CVERT_FUNCTION CVERT_OF(LipIntersection)
    intersectLip(CVERT_OF(Parabola) f, Real p0, Real p1, CVERT_OF(Lip) lip) {
  CVERT_OF(LipIntersection) at;
  at.hit = false;
  at.k = Real(0);
  Real k0 = Real(0), k1 = Real(1);
  if (p0 > lip.width) {
    if (p1 > lip.width) return at;
    k0 = (lip.width - p0) / (p1 - p0);
  } else if (p1 > lip.width) k1 = (lip.width - p0) / (p1 - p0);

  bool isBent = f.saddle != Real(0);
  Real vertex = Real(0.5f) + Real(0.5f) * (f.f1 - f.f0) / (isBent ? f.saddle : Real(1));
  bool hasVertex = isBent && vertex > k0 && vertex < k1;
  Real lowest = Real(beyondAll), highest = Real(-beyondAll);
  Real bottom = -(lip.depth + lip.epsilon);
  bool inside = false;
  at.k = k0;
  for (int i = 0; i < 3; i++) {
    if (i == 2 && !hasVertex) continue;
    Real k = i == 0 ? k0 : i == 1 ? k1 : vertex;
    Real value = parabolaAt(f, k);
    lowest = minimum(lowest, value);
    highest = maximum(highest, value);
    if (!inside && value <= lip.epsilon && value >= bottom) {
      inside = true;
      at.k = k;
    }
  }
  at.hit = lowest <= lip.epsilon && highest >= bottom;
  return at;
}

/* --- patches ------------------------------------------------------------------------- */

/*! Height of a leaf's patch at (u,v) in its box. */
CVERT_REAL CVERT_FUNCTION Real patchZ(LeafPatch leaf, Real u, Real v) {
  Real z0 = Real(leaf.z[0]), z1 = Real(leaf.z[1]), z2 = Real(leaf.z[2]), z3 = Real(leaf.z[3]);
  return z0 + u * (z1 - z0) + v * (z2 - z0) + u * v * (z0 - z1 - z2 + z3);
}

/*! Slope of a leaf's patch along an axis of the frame. across: v for axis 0, u for axis 1. Solid leaves are flat. */
CVERT_REAL CVERT_FUNCTION Real patchSlope(LeafPatch leaf, int axis, Real across) {
  if (leaf.solid) return Real(0);
  Real z0 = Real(leaf.z[0]), z1 = Real(leaf.z[1]), z2 = Real(leaf.z[2]), z3 = Real(leaf.z[3]);
  return ((axis == 0 ? z1 : z2) - z0 + across * (z0 - z1 - z2 + z3)) / Real(leaf.box.extent[axis]);
}

/*! Position of the ray at s in a box, clamped to 0 to 1. */
CVERT_REAL CVERT_FUNCTION Real positionInBox(CVERT_OF(Segment) segment, NodeBox box, int axis, Real s) {
  return clampToUnit((segmentAt(segment, axis, s) - Real(box.lower[axis])) / Real(box.extent[axis]));
}

/*! A ray's path through a leaf's box. */
CVERT_REAL struct Crossing {
  Real s0, s1;         //!< s at entry and exit, 0 to 1
  Real u0, v0, u1, v1; //!< position in the box at entry and exit, 0 to 1
  CVERT_OF(Parabola) f;
  LeafEvent event;
};

/*! Requires a segment that intersects the leaf's box. */
CVERT_REAL CVERT_FUNCTION CVERT_OF(Crossing) crossPatch(CVERT_OF(Segment) segment, LeafPatch leaf) {
  CVERT_OF(Crossing) x;
  CVERT_OF(Range) inBox = rangeInBox(segment, leaf.box, 3), inColumn = rangeInBox(segment, leaf.box, 2);
  x.s0 = maximum(inBox.lower, Real(0));
  x.s1 = minimum(inBox.upper, Real(1));
  x.u0 = positionInBox(segment, leaf.box, 0, x.s0);
  x.v0 = positionInBox(segment, leaf.box, 1, x.s0);
  x.u1 = positionInBox(segment, leaf.box, 0, x.s1);
  x.v1 = positionInBox(segment, leaf.box, 1, x.s1);
  x.f.f0 = segmentAt(segment, 2, x.s0) - patchZ(leaf, x.u0, x.v0);
  x.f.f1 = segmentAt(segment, 2, x.s1) - patchZ(leaf, x.u1, x.v1);
  x.f.saddle = (Real(leaf.z[0]) - Real(leaf.z[1]) - Real(leaf.z[2]) + Real(leaf.z[3])) * (x.u1 - x.u0) * (x.v1 - x.v0);

  LeafEvent event;
  event.solid = leaf.solid;
  event.empty = leaf.empty;
  event.started = segment.startClipped && inBox.lower < Real(0);
  event.ended = segment.endClipped && inBox.upper > Real(1);
  bool up = segment.P1[2] >= segment.P0[2];
  bool above0 = x.f.f0 >= Real(0), above1 = x.f.f1 >= Real(0);
  event.changes = above0 != above1;
  /* a ray that enters or leaves through the upper (lower) face of the box is above (below) there */
  if (inBox.lower > inColumn.lower && !event.started) above0 = !up;
  if (inBox.upper < inColumn.upper && !event.ended) above1 = up;
  event.enter = above0 ? sideAbove : sideBelow;
  event.leave = above1 ? sideAbove : sideBelow;
  Real tolerance = Real(0.5f * leaf.thickness) + segment.epsilon[2];
  event.nearEntry = magnitude(x.f.f0) <= tolerance;
  event.near =
      event.changes || minimum(magnitude(x.f.f0), magnitude(x.f.f1)) <= tolerance + Real(0.25f) * magnitude(x.f.saddle);
  x.event = event;
  return x;
}

/*! Intersects a ray with the lips of leaf (leafX,leafY). Returns the first one hit: lower x, upper x, lower y,
 *  upper y. last: index of the last leaf along a side of the block. */
CVERT_REAL CVERT_FUNCTION CVERT_OF(LipIntersection)
    intersectLipsOfLeaf(CVERT_OF(Crossing) x, uint32_t leafX, uint32_t leafY, uint32_t last, CVERT_OF(Lip) lip) {
  CVERT_OF(LipIntersection) at;
  at.hit = false;
  at.k = Real(0);
  for (int side = 0; side < 4; side++) {
    uint32_t position = side < 2 ? leafX : leafY;
    bool upper = (side & 1) != 0;
    if (at.hit || position != (upper ? last : 0u)) continue;
    Real p0 = side < 2 ? x.u0 : x.v0, p1 = side < 2 ? x.u1 : x.v1;
    if (upper) {
      p0 = Real(1) - p0;
      p1 = Real(1) - p1;
    }
    at = intersectLip(x.f, p0, p1, lip);
  }
  return at;
}

CBVH_END

#endif
