// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* How rays hit triangles of cVERT: single rays, packets, shaders and tests. docs/formats/rays.md specifies it. In the
 * order of use:
 *
 *   boxes        by how much boxes are enlarged, so that rounding never culls a hit
 *   sides        on which side of an edge the ray is, in the sheared space in which the ray is the z axis
 *   containment  whether the ray's line passes through a triangle: sides, and exact signs if a side rounded to 0
 *   distance     of the hit: at the triangle's plane, clamped to the triangle's extent along the ray
 *   nearest hit  whether a hit counts: within the ray, and nearer than the previous one or preferred to it
 *   parameters   (u,v) of a hit on the face
 *
 * A quad has the triangles of GRID, (00,10,01) and (01,10,11), and five edges:
 *
 *     01---top---11
 *      | \        |      triangle 0: diagonal, left, bottom
 *    left  diag  right   triangle 1: right, top, -diagonal
 *      |      \   |
 *     00-bottom--10
 *
 * One text serves single rays, packets and shaders. The macros of portable/language.h make a function with CVERT_REAL a
 * template in C++, over the type Real: float for single rays, a vector with one ray (or one triangle) per lane for
 * SIMD. In GLSL they vanish, and Real is float. This is clipInterval, below, as compilers see it:
 *
 *   the text             CVERT_REAL CVERT_INLINE CVERT_OF(RayInterval)
 *                          clipInterval(CVERT_OF(RayInterval) interval, Real lower, Real upper, Real rcp)
 *   C++                  template<typename Real> inline __attribute__((always_inline)) RayInterval<Real>
 *                          clipInterval(RayInterval<Real> interval, Real lower, Real upper, Real rcp)
 *     single ray         RayInterval<float> clipInterval(RayInterval<float>, float, float, float)
 *     packet of 8        RayInterval<vfloat<8>> clipInterval(RayInterval<vfloat<8>>, vfloat<8>, vfloat<8>, vfloat<8>)
 *   GLSL                 RayInterval
 *                          clipInterval(RayInterval interval, float lower, float upper, float rcp)
 *
 * The body, `interval.from = maximum(interval.from, minimum(a, b))`, compiles in each, since language.h defines
 * maximum, minimum, product, choose, both and either for float and in GLSL, and base/vectors.h for vectors. A condition
 * has the type CVERT_BOOL(Real): bool, or a mask with a bit per lane. Therefore functions have no `if` on it: they
 * compute both cases and choose(). Wide, a second parameter, is a type in which products of two Reals are exact:
 * double, or a vector of doubles.
 *
 * Based on: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013. */

#ifndef CVERT_RULE_RULE_H
#define CVERT_RULE_RULE_H

#include "../format/block.h"
#include "reciprocal.h"

CVERT_BEGIN

/* --- boxes --------------------------------------------------------------------------- */

/*! Bound of the rounding errors of sheared vertices, boxes and distances to them, in floatUlp: 1/2 for a difference,
 *  3/2 for a shear, 3 for each of two distances to planes. Shaders divide with errors of up to 2.5 ulps instead of 1/2:
 *  this adds 2 to the shear and 2 to each distance. */
#ifdef VULKAN
CVERT_CONSTANT float slackUlps = 14.0f;
#else
CVERT_CONSTANT float slackUlps = 8.0f;
#endif

/*! The same for the boxes of tiles (format/tile.h). Per distance to a plane: 1/2 for the difference of origins, 1/2 for
 *  its product with the reciprocal, 1/2 for the slack's addition, 1/2 for the unit's product, 1 for the plane
 *  (unfused), 3/2 for the reciprocal, twice; and 3/2 for the shear of vertices. Shaders: 2 more for the shear and for
 *  each reciprocal. */
#ifdef VULKAN
CVERT_CONSTANT float tileSlackUlps = 19.0f;
#else
CVERT_CONSTANT float tileSlackUlps = 13.0f;
#endif

/*! As slackUlps for the sheared coordinate (format/block.h), a sum of three terms. */
CVERT_CONSTANT float shearedSlackUlps = 2.0f * slackUlps;

/*! Distance by which planes on a world axis move outwards. org, origin: of the ray and of the block. extent: bound of
 *  the distance from the block's origin to planes, such as extentOfBounds. */
CVERT_REAL CVERT_INLINE Real boxSlack(Real org, float origin, float extent) {
  return Real(slackUlps * floatUlp) * (magnitude(Real(origin) - org) + Real(extent));
}

/*! Sheared coordinates of a ray's origin, relative to the block's origin, and of its direction. */
CVERT_REAL struct ShearedCoordinate {
  Real org, dir;
  Real size; //!< factor of the rounding errors of org and of planes, see shearedSlack
};

CVERT_REAL CVERT_INLINE CVERT_OF(ShearedCoordinate) zeroShearedCoordinate() {
  CVERT_OF(ShearedCoordinate) sum;
  sum.org = sum.dir = sum.size = Real(0.0f);
  return sum;
}

/*! Adds the term of a world axis. org, dir: of the ray. origin: of the block. extent: as in boxSlack. shear: factor of
 *  the axis. */
CVERT_REAL CVERT_INLINE CVERT_OF(ShearedCoordinate)
    addSheared(CVERT_OF(ShearedCoordinate) sum, Real org, Real dir, float origin, float extent, float shear) {
  Real distance = org - Real(origin);
  sum.org = sum.org + Real(shear) * distance;
  sum.dir = sum.dir + Real(shear) * dir;
  sum.size = sum.size + magnitude(Real(shear)) * (magnitude(distance) + Real(extent));
  return sum;
}

/*! Distance by which sheared planes move outwards. size: ShearedCoordinate::size. */
CVERT_REAL CVERT_INLINE Real shearedSlack(Real size) { return Real(shearedSlackUlps * floatUlp) * size; }

/*! Factor of world axis shearedAxis+i in the sheared coordinate. */
CVERT_FUNCTION float worldShear(uint32_t info, int i) {
  return i == 0 ? 1.0f : float(shearSlope(info, i)) * (1.0f / 16.0f);
}

CVERT_REAL struct RayInterval {
  Real from, to;
};

/*! Clips an interval of the ray to two planes. lower, upper: relative to the ray's origin. rcp: directionReciprocal. */
CVERT_REAL CVERT_INLINE CVERT_OF(RayInterval)
    clipInterval(CVERT_OF(RayInterval) interval, Real lower, Real upper, Real rcp) {
  Real a = lower * rcp, b = upper * rcp;
  interval.from = maximum(interval.from, minimum(a, b));
  interval.to = minimum(interval.to, maximum(b, a)); // with (a,b), compilers merge both lines into a branch
  return interval;
}

/* --- sides --------------------------------------------------------------------------- */

/*! Axis of the largest magnitude, or the first of several. A comparison with NaN chooses the later axis. x, y, z:
 *  magnitudes. Without branches, which would be mispredicted. */
CVERT_FUNCTION int largestAxis(float x, float y, float z) {
  int isY = int(!(x >= y)), isZ = (isY & int(!(y >= z))) | ((1 - isY) & int(!(x >= z)));
  return 2 * isZ + (isY & (1 - isZ));
}

/*! Side of the ray on which the sheared edge from a to b lies. The edge's other triangle gets the exact negative.
 *  Results may round to 0, but never to the wrong sign, because rounding is monotonic. */
CVERT_REAL CVERT_INLINE Real edgeSide(Real ax, Real ay, Real bx, Real by) {
  CVERT_PRECISE Real side = product(ax, by) - product(ay, bx); // drivers must not fuse the difference
  return side;
}

/*! True if no two of the sides have opposite signs. Never false if the ray passes through the triangle, but may be true
 *  for a miss if a side rounded to 0. */
CVERT_REAL CVERT_INLINE CVERT_BOOL(Real) mayContain(Real a, Real b, Real c) {
  return either(minimum(a, minimum(b, c)) >= Real(0.0f), maximum(a, maximum(b, c)) <= Real(0.0f));
}

/*! Sides of the three edges. Divided by their sum, they are the barycentric weights of the opposite vertices. */
CVERT_REAL struct TriangleSides {
  Real w0, w1, w2, sum;
};

/*! a, b, c: vertices in the sheared space, relative to the ray. */
CVERT_REAL CVERT_INLINE CVERT_OF(TriangleSides) triangleSides(Real ax, Real ay, Real bx, Real by, Real cx, Real cy) {
  CVERT_OF(TriangleSides) sides;
  sides.w0 = edgeSide(bx, by, cx, cy);
  sides.w1 = edgeSide(cx, cy, ax, ay);
  sides.w2 = edgeSide(ax, ay, bx, by);
  sides.sum = sides.w0 + sides.w1 + sides.w2;
  return sides;
}

/*! True if no side rounded to 0 and their sum is finite, for triangles that satisfy mayContain. minimum and maximum are
 *  nested differently, because compilers would otherwise generate a branch that is mispredicted. */
CVERT_REAL CVERT_INLINE CVERT_BOOL(Real) haveExactSigns(CVERT_OF(TriangleSides) sides) {
  return both(either(Real(0.0f) < minimum(sides.w0, minimum(sides.w1, sides.w2)),
                     maximum(maximum(sides.w0, sides.w1), sides.w2) < Real(0.0f)),
              magnitude(sides.sum) < Real(infinity));
}

/* --- containment --------------------------------------------------------------------- */

/*! Exact product of two finite floats in integers: the product of the mantissas, normalized, and the exponent. */
struct ExactProduct {
  int exponent;
  uint32_t high, low; //!< 24 bits each; 0 if the product is 0
  bool isNegative;
};

CVERT_FUNCTION ExactProduct exactProduct(float a, float b) {
  uint32_t s = bitsOfFloat(a), t = bitsOfFloat(b);
  uint32_t m = s & 0x7FFFFFu, n = t & 0x7FFFFFu;
  int e = int((s >> 23) & 255u), f = int((t >> 23) & 255u);
  if (e != 0) m |= 0x800000u;
  else e = 1;
  if (f != 0) n |= 0x800000u;
  else f = 1;

  // halves of 12 bits
  uint32_t cross = (m >> 12) * (n & 4095u) + (m & 4095u) * (n >> 12);
  uint32_t low = (m & 4095u) * (n & 4095u) + ((cross & 4095u) << 12);
  ExactProduct p;
  p.high = (m >> 12) * (n >> 12) + (cross >> 12) + (low >> 24);
  p.low = low & 0xFFFFFFu;
  p.exponent = e + f;
  p.isNegative = ((s ^ t) >> 31) != 0u;
  if ((p.high | p.low) == 0u) {
    p.exponent = 0;
    p.isNegative = false;
    return p;
  }
  for (int i = 0; i < 47 && (p.high & 0x800000u) == 0u; i++) {
    p.high = (p.high << 1) | (p.low >> 23);
    p.low = (p.low << 1) & 0xFFFFFFu;
    p.exponent--;
  }
  return p;
}

/*! Sign of |p| - |q|. */
CVERT_FUNCTION int compareMagnitudes(ExactProduct p, ExactProduct q) {
  bool isZeroP = (p.high | p.low) == 0u, isZeroQ = (q.high | q.low) == 0u;
  if (isZeroP || isZeroQ) return isZeroP ? (isZeroQ ? 0 : -1) : 1;
  if (p.exponent != q.exponent) return p.exponent < q.exponent ? -1 : 1;
  if (p.high != q.high) return p.high < q.high ? -1 : 1;
  if (p.low != q.low) return p.low < q.low ? -1 : 1;
  return 0;
}

/*! Sign of ax by - ay bx, by integer arithmetic. The arguments must be finite. */
CVERT_FUNCTION int exactSideOfFloats(float ax, float ay, float bx, float by) {
  ExactProduct p = exactProduct(ax, by), q = exactProduct(ay, bx);
  if (p.isNegative == q.isNegative) return p.isNegative ? -compareMagnitudes(p, q) : compareMagnitudes(p, q);
  return p.isNegative ? -1 : 1; // the negative product is not 0
}

#if !defined(VULKAN) || defined(CBVH_FLOAT64)
/*! The same: products of floats are exact in double. */
CVERT_FUNCTION int exactSide(float ax, float ay, float bx, float by) {
  double p = double(ax) * double(by), q = double(ay) * double(bx);
  return p > q ? 1 : p < q ? -1 : 0;
}
#else
CVERT_FUNCTION int exactSide(float ax, float ay, float bx, float by) { return exactSideOfFloats(ax, ay, bx, by); }
#endif

/*! True if the ray passes through the triangle, by exact signs. For triangles that satisfy mayContain, but not
 *  haveExactSigns. A side of 0 is inside for both triangles of its edge. A triangle with three sides of 0 is a line,
 *  which other triangles cover. */
CVERT_FUNCTION bool contains(float ax, float ay, float bx, float by, float cx, float cy) {
  // each coordinate: a sum of finite ones may overflow
  bool areFinite = magnitude(ax) < infinity && magnitude(ay) < infinity && magnitude(bx) < infinity &&
                   magnitude(by) < infinity && magnitude(cx) < infinity && magnitude(cy) < infinity;
  if (!areFinite) return false;
  int s0 = exactSide(bx, by, cx, cy), s1 = exactSide(cx, cy, ax, ay), s2 = exactSide(ax, ay, bx, by);
  bool isPositive = s0 > 0 || s1 > 0 || s2 > 0, isNegative = s0 < 0 || s1 < 0 || s2 < 0;
  return isPositive != isNegative;
}

/* --- distance ------------------------------------------------------------------------ */

/*! Vertices of a triangle: at[axis][vertex]. Differences of floats are exact in double if their exponents differ by at
 *  most 28. */
CVERT_WIDE struct WideTriangle {
  Wide at[3][3];
};

/*! Cross product of the edges from the first vertex; 0 for a line. */
CVERT_WIDE struct WideNormal {
  Wide at[3];
};

CVERT_WIDE CVERT_INLINE CVERT_OF_WIDE(WideNormal) normalOf(CVERT_OF_WIDE(WideTriangle) triangle) {
  Wide e[3], f[3];
  for (int k = 0; k < 3; k++) {
    e[k] = triangle.at[k][1] - triangle.at[k][0];
    f[k] = triangle.at[k][2] - triangle.at[k][0];
  }
  CVERT_OF_WIDE(WideNormal) n;
  n.at[0] = product(e[1], f[2]) - product(e[2], f[1]);
  n.at[1] = product(e[2], f[0]) - product(e[0], f[2]);
  n.at[2] = product(e[0], f[1]) - product(e[1], f[0]);
  return n;
}

/*! A ray lies in a plane if |n d| is at most this fraction of the sum of |n_k d_k| (n: normal, d: direction): vertices
 *  of 24 bits do not resolve smaller angles. */
CVERT_CONSTANT float inPlaneTolerance = 1e-6f;

CVERT_WIDE struct PlaneIntersection {
  Wide t; //!< distance; NaN if the ray is parallel to the plane
  Wide normalDotDir;
  Wide parallelLimit; //!< the ray counts as lying in the plane if |normalDotDir| is at most this
};

CVERT_WIDE CVERT_INLINE CVERT_OF_WIDE(PlaneIntersection)
    intersectPlane(CVERT_OF_WIDE(WideTriangle) triangle, CVERT_OF_WIDE(WideNormal) normal, const Wide org[3],
                   const Wide dir[3]) {
  Wide height = Wide(0.0f), normalDotDir = Wide(0.0f), size = Wide(0.0f);
  for (int k = 0; k < 3; k++) {
    Wide along = product(normal.at[k], dir[k]);
    normalDotDir = normalDotDir + along;
    size = size + magnitude(along);
    height = height + product(normal.at[k], triangle.at[k][0] - org[k]);
  }
  CVERT_OF_WIDE(PlaneIntersection) at;
  at.t = height / nonZero(normalDotDir);
  at.normalDotDir = normalDotDir;
  at.parallelLimit = Wide(inPlaneTolerance) * size;
  return at;
}

/*! Distances of vertices along a ray. */
CVERT_WIDE struct TriangleSpan {
  Wide nearest, farthest;
};

/*! The arguments are components on the axis on which the direction is largest. z0, z1, z2: of the vertices. Divides
 *  only the lowest and the highest difference, because division is monotonic. */
CVERT_WIDE CVERT_INLINE CVERT_OF_WIDE(TriangleSpan) spanOf(Wide z0, Wide z1, Wide z2, Wide org, Wide dir) {
  Wide d0 = z0 - org, d1 = z1 - org, d2 = z2 - org;
  Wide a = minimum(d0, minimum(d1, d2)) / dir, b = maximum(maximum(d0, d1), d2) / dir;
  CVERT_OF_WIDE(TriangleSpan) span;
  span.nearest = minimum(a, b);
  span.farthest = maximum(b, a);
  return span;
}

CVERT_WIDE CVERT_INLINE Wide clampToSpan(CVERT_OF_WIDE(TriangleSpan) span, Wide t) {
  return minimum(maximum(t, span.nearest), span.farthest);
}

/*! True if the plane determines the distance: the ray does not lie in it, or the distance is within the triangle. */
CVERT_WIDE CVERT_INLINE CVERT_BOOL(Wide)
    isPlaneDecisive(CVERT_OF_WIDE(PlaneIntersection) at, CVERT_OF_WIDE(TriangleSpan) span) {
  return either(at.parallelLimit < magnitude(at.normalDotDir), both(span.nearest <= at.t, at.t <= span.farthest));
}

/*! Distance along the ray at which it is nearest to the triangle's longest edge. */
CVERT_WIDE CVERT_FUNCTION Wide distanceAtLongestEdge(CVERT_OF_WIDE(WideTriangle) triangle, const Wide org[3],
                                                     const Wide dir[3]) {
  Wide best = Wide(-1.0f), t = Wide(0.0f);
  for (int i = 0; i < 3; i++) {
    int j = i == 2 ? 0 : i + 1;
    Wide ee = Wide(0.0f), dd = Wide(0.0f), de = Wide(0.0f), dw = Wide(0.0f), ew = Wide(0.0f);
    for (int k = 0; k < 3; k++) {
      Wide e = triangle.at[k][j] - triangle.at[k][i], w = triangle.at[k][i] - org[k], d = dir[k];
      ee += e * e;
      dd += d * d;
      de += d * e;
      dw += d * w;
      ew += e * w;
    }
    if (ee <= best) continue;
    best = ee;
    Wide det = dd * ee - de * de;
    // position on the edge
    Wide s = det > Wide(0.0f) ? minimum(maximum((de * dw - dd * ew) / det, Wide(0.0f)), Wide(1.0f)) : Wide(0.0f);
    t = (dw + s * de) / dd;
  }
  return t;
}

/*! Distance of the hit of a triangle that the ray's line passes through: at the plane, because weights of needles have
 *  larger errors. If the plane is not decisive, where the ray is nearest to the longest edge, but not before tnear
 *  unless the whole triangle is: otherwise the ray could leave a closed surface without a hit. */
CVERT_WIDE CVERT_FUNCTION Wide distanceOfHit(CVERT_OF_WIDE(WideTriangle) triangle, CVERT_OF_WIDE(WideNormal) normal,
                                             CVERT_OF_WIDE(TriangleSpan) span, const Wide org[3], const Wide dir[3],
                                             Wide tnear) {
  CVERT_OF_WIDE(PlaneIntersection) at = intersectPlane(triangle, normal, org, dir);
  if (CVERT_LIKELY(isPlaneDecisive(at, span))) return clampToSpan(span, at.t);
  Wide t = clampToSpan(span, distanceAtLongestEdge(triangle, org, dir));
  return tnear <= span.farthest ? maximum(t, tnear) : t;
}

/* --- nearest hit --------------------------------------------------------------------- */

/* Results of classifyHit. */
CVERT_CONSTANT uint32_t hitIsOutOfRange = 0u; //!< the hit does not count
CVERT_CONSTANT uint32_t hitIsInRange = 1u;    //!< the hit counts
CVERT_CONSTANT uint32_t hitIsTied = 2u;       //!< the hit counts if its triangle has precedence, see hasPrecedence

/*! Decides whether a hit counts. distance: of the hit. tfar: end of the ray, or distance of its nearest hit.
 *  isHitDistance: tfar is the distance of a cVERT hit, rounded to float; both are then compared as floats. */
CVERT_WIDE CVERT_INLINE uint32_t classifyHit(Wide distance, float tnear, float tfar, bool isHitDistance) {
  float t = float(distance);
  uint32_t farther = isHitDistance ? (t == tfar ? hitIsTied : hitIsOutOfRange)
                                   : (distance <= Wide(tfar) ? hitIsInRange : hitIsOutOfRange);
  return !(distance >= Wide(tnear)) ? hitIsOutOfRange : CVERT_LIKELY(t < tfar) ? hitIsInRange : farther;
}

/*! Orders triangles of a scene or an instance that are hit at the same distance. */
struct TriangleKey {
  uint32_t geomID, primID; //!< primID: of the block's header
  uint32_t region;         //!< VertHeader::region, or MeshHeader::bytes, which has the same offset
  uint32_t triangle; //!< 32 (column + 4 row) of the group in the block + 2 (column + 4 row) of the quad in the group
                     //!< + 1 for the second triangle of the quad; in a mesh block: 32 group + triangle
};

/*! True if triangle a is hit rather than b at the same distance. Makes results independent of the order in which
 *  blocks are tested. */
CVERT_FUNCTION bool hasPrecedence(TriangleKey a, TriangleKey b) {
  if (a.geomID != b.geomID) return a.geomID < b.geomID;
  if (a.primID != b.primID) return a.primID < b.primID;
  return a.region != b.region ? a.region < b.region : a.triangle < b.triangle;
}

/*! Corner (column + 2 row) of the quad at a vertex of a triangle. index: of the triangle in its group, 0 to 31, that
 *  is, TriangleKey::triangle modulo 32. */
CVERT_FUNCTION uint32_t cornerOfTriangle(uint32_t index, int vertex) {
  bool isSecond = (index & 1u) != 0u;
  return vertex == 0 ? (isSecond ? 2u : 0u) : vertex == 1 ? 1u : (isSecond ? 3u : 2u);
}

/* Column and row of a triangle's quad in the group. index: see cornerOfTriangle. */
CVERT_FUNCTION uint32_t quadXOfTriangle(uint32_t index) { return (index >> 1) & 3u; }
CVERT_FUNCTION uint32_t quadYOfTriangle(uint32_t index) { return index >> 3; }

/* --- parameters ---------------------------------------------------------------------- */

/*! Position in a quad, 0 to 1 along each side. */
CVERT_REAL struct QuadPosition {
  Real a, b;
};

CVERT_REAL CVERT_INLINE CVERT_OF(QuadPosition)
    positionInQuad(CVERT_OF(TriangleSides) sides, CVERT_BOOL(Real) isSecond) {
  // weights of the second and third vertex; NaN if all sides rounded to 0
  Real b1 = sides.w1 / sides.sum, b2 = sides.w2 / sides.sum;
  CVERT_OF(QuadPosition) position;
  position.a = choose(isSecond, b1 + b2, b1);
  position.b = choose(isSecond, Real(1.0f) - b1, b2);
  return position;
}

/*! Clamps to 0 to 1. NaN, of a sliver whose sides all rounded to 0, becomes 1/2: the diagonal's middle belongs to both
 *  triangles. */
CVERT_REAL CVERT_INLINE Real clampParameter(Real x) {
  return choose(x >= Real(0.0f), minimum(x, Real(1.0f)), choose(x < Real(0.0f), Real(0.0f), Real(0.5f)));
}

/*! Face parameter at position a (0 to 1) of quad x. quads: of the patch in this direction. corner: vertCornerU or V. */
CVERT_REAL CVERT_INLINE Real faceParameterOfQuad(uint32_t corner, Real x, Real a, uint32_t quads) {
  return Real(0.5f * float(corner)) + maximum((x + clampParameter(a)) / Real(float(quads)), Real(0.0f));
}

/* First quad of a group in the patch. lane: column + 4 row of the group in the block, its lane in SIMD code. */
CVERT_FUNCTION uint32_t firstQuadX(uint32_t region, uint32_t lane) {
  return vertFirstX(region) + groupQuads * (lane & 3u);
}
CVERT_FUNCTION uint32_t firstQuadY(uint32_t region, uint32_t lane) {
  return vertFirstY(region) + groupQuads * (lane >> 2);
}

/*! True if an edge has a lower rate than the patch has quads. Requires a block with edges. */
CVERT_FUNCTION bool hasStitchedEdge(uint32_t patchQuads, VertEdges edges) {
  uint32_t quadsX = patchQuadsX(patchQuads), quadsY = patchQuadsY(patchQuads);
  return vertRate(edges, 0) != quadsX || vertRate(edges, 1) != quadsY || vertRate(edges, 2) != quadsX ||
         vertRate(edges, 3) != quadsY;
}

/*! True if quad (x,y) is next to such an edge: its vertices are stitched. */
CVERT_FUNCTION bool isAtStitchedEdge(uint32_t patchQuads, VertEdges edges, uint32_t x, uint32_t y) {
  uint32_t quadsX = patchQuadsX(patchQuads), quadsY = patchQuadsY(patchQuads);
  return (y == 0u && vertRate(edges, 0) != quadsX) || (x + 1u == quadsX && vertRate(edges, 1) != quadsY) ||
         (y + 1u == quadsY && vertRate(edges, 2) != quadsX) || (x == 0u && vertRate(edges, 3) != quadsY);
}

struct FaceParameters {
  float u, v;
};

/*! Face parameters at position (a,b) of a quad for which isAtStitchedEdge is true: interpolates the parameters of its
 *  vertices with barycentric weights. */
CVERT_FUNCTION FaceParameters parametersAtStitchedEdge(uint32_t patchQuads, VertEdges edges, uint32_t x, uint32_t y,
                                                       bool isSecond, float a, float b) {
  uint32_t quadsX = patchQuadsX(patchQuads), quadsY = patchQuadsY(patchQuads);
  float p = clampParameter(a), q = clampParameter(b), s = 0.0f, t = 0.0f;
  for (uint32_t c = 0u; c < 4u; c++) {
    float w = c == 0u   ? (isSecond ? 0.0f : 1.0f - p - q)
              : c == 1u ? (isSecond ? 1.0f - q : p)
              : c == 2u ? (isSecond ? 1.0f - p : q)
                        : (isSecond ? p + q - 1.0f : 0.0f);
    uint32_t i = x + (c & 1u), j = y + (c >> 1);
    s += w * CVERT_AS_FLOAT(vertParameter)(i, quadsX,
                                           j == 0u       ? vertRate(edges, 0)
                                           : j == quadsY ? vertRate(edges, 2)
                                                         : quadsX);
    t += w * CVERT_AS_FLOAT(vertParameter)(j, quadsY,
                                           i == 0u       ? vertRate(edges, 3)
                                           : i == quadsX ? vertRate(edges, 1)
                                                         : quadsY);
  }
  FaceParameters parameters;
  parameters.u = 0.5f * float(vertCornerU(edges)) + maximum(s, 0.0f);
  parameters.v = 0.5f * float(vertCornerV(edges)) + maximum(t, 0.0f);
  return parameters;
}

/*! Primitive and parameters that a hit reports. */
struct SurfacePoint {
  uint32_t primID;
  float u, v;
};

/*! For blocks with primitive numbers. lane: see firstQuadX. index: see cornerOfTriangle. */
CVERT_INLINE SurfacePoint pointOfNumberedQuad(CVERT_POINTER(VertHeader) block, uint32_t lane, uint32_t index,
                                              CVERT_AS_FLOAT(QuadPosition) at) {
  uint32_t x = groupQuads * (lane & 3u) + quadXOfTriangle(index), y = groupQuads * (lane >> 2) + quadYOfTriangle(index);
  bool isSecond = (index & 1u) != 0u;
  QuadPrimitive primitive = primitiveOfQuad(block, x, y, isSecond);
  PrimitiveParameters own =
      primitiveParameters(primitive.numbering, isSecond, clampParameter(at.a), clampParameter(at.b));
  SurfacePoint point;
  point.primID = primitive.primID;
  point.u = own.u;
  point.v = own.v;
  return point;
}

/*! For all other blocks. */
CVERT_INLINE SurfacePoint pointOfPatch(CVERT_POINTER(VertHeader) block, uint32_t lane, uint32_t index,
                                       CVERT_AS_FLOAT(QuadPosition) at) {
  uint32_t patchQuads = CVERT_AT(VertHeader, block).patchQuads, region = CVERT_AT(VertHeader, block).region;
  uint32_t x = firstQuadX(region, lane) + quadXOfTriangle(index), y = firstQuadY(region, lane) + quadYOfTriangle(index);
  uint32_t cornerU = 0u, cornerV = 0u;
  SurfacePoint point;
  point.primID = CVERT_AT(VertHeader, block).primID;
  if (!CVERT_LIKELY(!hasEdges(CVERT_AT(VertHeader, block).info))) {
    VertEdges edges = edgesOf(block);
    if (isAtStitchedEdge(patchQuads, edges, x, y)) {
      FaceParameters parameters = parametersAtStitchedEdge(patchQuads, edges, x, y, (index & 1u) != 0u, at.a, at.b);
      point.u = parameters.u;
      point.v = parameters.v;
      return point;
    }
    cornerU = vertCornerU(edges);
    cornerV = vertCornerV(edges);
  }
  point.u = faceParameterOfQuad(cornerU, float(x), at.a, patchQuadsX(patchQuads));
  point.v = faceParameterOfQuad(cornerV, float(y), at.b, patchQuadsY(patchQuads));
  return point;
}

CVERT_INLINE SurfacePoint surfacePoint(CVERT_POINTER(VertHeader) block, uint32_t lane, uint32_t index,
                                       CVERT_AS_FLOAT(QuadPosition) at) {
  if (hasPrimIDs(CVERT_AT(VertHeader, block).info)) return pointOfNumberedQuad(block, lane, index, at);
  return pointOfPatch(block, lane, index, at);
}

CVERT_END

#endif
