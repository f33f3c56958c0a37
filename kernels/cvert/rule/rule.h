// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The rule by which rays hit the triangles of cVERT, which docs/formats/rays.md specifies: one text for single rays,
 * packets, shaders and tests. It is, in the order in which a ray needs it,
 *
 *   boxes        how far they are widened, as they only cull
 *   sides        on which side of an edge the ray is, in the sheared space in which the ray is the z axis
 *   containment  whether the ray's line goes through a triangle: sides, and their exact signs where one rounded to 0
 *   distance     where it goes through: the triangle's plane, kept within the triangle's extent along the ray
 *   nearest hit  whether a hit is within the ray and nearer than the one before; of two at one distance, which counts
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
 * Numbers are Real: a float, or a vector of floats with a ray or a quad in each lane; and Wide, in which products of
 * Reals are exact: a double, or a vector of them. In shaders without 64-bit floats Wide is a float, too, and signs
 * are exact in integers.
 *
 * Based on: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013. */

#ifndef CVERT_VERT_RULE_H
#define CVERT_VERT_RULE_H

#include "../format/block.h"
#include "reciprocal.h"

CVERT_BEGIN

/* --- boxes --------------------------------------------------------------------------- */

/*! Ulps that the sheared vertices, the boxes and the ray's distances to them may be off together: a difference is
 *  off by a half, a shear by three halves, a plane's distance by three, each of the two. In shaders a quotient is off
 *  by up to 2.5 ulps instead of a half: that adds 2 to the shear, and 2 to each of the two distances. */
#ifdef VULKAN
CVERT_CONSTANT float slackUlps = 14.0f;
#else
CVERT_CONSTANT float slackUlps = 8.0f;
#endif

/*! the same of the sheared coordinate, where the ray's start and its direction are sums of three */
CVERT_CONSTANT float shearedSlackUlps = 2.0f*slackUlps;

/*! what is to be added to planes of a world axis; extent: of the block from its origin, at least */
CVERT_REAL CVERT_INLINE Real boxSlack (Real org, float origin, float extent) {
  return Real(slackUlps*floatUlp)*(magnitude(Real(origin)-org) + Real(extent));
}

/*! a ray along the sheared coordinate of a block's boxes, from the block's origin */
CVERT_REAL struct ShearedCoordinate
{
  Real org, dir;
  Real size;  //!< of what org may have lost to rounding
};

CVERT_REAL CVERT_INLINE CVERT_OF(ShearedCoordinate) noShearedCoordinate ()
{
  CVERT_OF(ShearedCoordinate) sum;
  sum.org = sum.dir = sum.size = Real(0.0f);
  return sum;
}

/*! adds what a world axis contributes to it; shear: factor of the axis */
CVERT_REAL CVERT_INLINE CVERT_OF(ShearedCoordinate) addSheared (CVERT_OF(ShearedCoordinate) sum, Real org, Real dir, float origin, float extent, float shear)
{
  Real distance = org-Real(origin);
  sum.org = sum.org + Real(shear)*distance;
  sum.dir = sum.dir + Real(shear)*dir;
  sum.size = sum.size + magnitude(Real(shear))*(magnitude(distance) + Real(extent));
  return sum;
}

/*! what is to be added to planes of the sheared coordinate */
CVERT_REAL CVERT_INLINE Real shearedSlack (Real size) { return Real(shearedSlackUlps*floatUlp)*size; }

/*! What a world axis counts in the sheared coordinate of boxes: the sheared axis m (i = 0), the next axis (1) and the
 *  one after it (2). */
CVERT_FUNCTION float shearOf (uint32_t boxForm, int i) {
  return i == 0 ? 1.0f : float(shearSlope(boxForm,i))*(1.0f/16.0f);
}

/*! part of a ray that is between planes */
CVERT_REAL struct RayInterval { Real from, to; };

/*! lower, upper: planes from the ray's origin; rcp: directionReciprocal */
CVERT_REAL CVERT_INLINE CVERT_OF(RayInterval) clipped (CVERT_OF(RayInterval) interval, Real lower, Real upper, Real rcp)
{
  Real a = lower*rcp, b = upper*rcp;
  interval.from = greater(interval.from,lesser(a,b));
  interval.to = lesser(interval.to,greater(b,a)); // not (a,b): the compiler would make one branch of both
  return interval;
}

/* --- sides --------------------------------------------------------------------------- */

/*! Returns the axis of the largest of three magnitudes, the first if several are equal. NaN counts as largest. It has
 *  no branches, which a processor would often mispredict. */
CVERT_FUNCTION int largestAxis (float x, float y, float z)
{
  int isY = int(!(x >= y)), isZ = (isY & int(!(y >= z))) | ((1-isY) & int(!(x >= z)));
  return 2*isZ + (isY & (1-isZ));
}

/*! Side of the ray on which the edge from a to b lies, sheared. Seen from the edge's other triangle it is the exact
 *  negative, as products commute; and as rounding is monotonic, it may round to 0 but never to the wrong sign. */
CVERT_REAL CVERT_INLINE Real edgeSide (Real ax, Real ay, Real bx, Real by)
{
  CVERT_PRECISE Real side = product(ax,by) - product(ay,bx); // CVERT_PRECISE: no driver may fuse the difference either
  return side;
}

/*! whether the ray is on one side of three edges, or on some of them: no triangle that has it is left out */
CVERT_REAL CVERT_INLINE CVERT_BOOL(Real) isInside (Real a, Real b, Real c) {
  return either(lesser(a,lesser(b,c)) >= Real(0.0f),greater(a,greater(b,c)) <= Real(0.0f));
}

/*! The sides of a triangle's edges. Each is the weight of the vertex opposite. */
CVERT_REAL struct TriangleSides
{
  Real w0, w1, w2, sum;
};

/*! of its sheared vertices a, b and c */
CVERT_REAL CVERT_INLINE CVERT_OF(TriangleSides) triangleSides (Real ax, Real ay, Real bx, Real by, Real cx, Real cy)
{
  CVERT_OF(TriangleSides) sides;
  sides.w0 = edgeSide(bx,by,cx,cy);
  sides.w1 = edgeSide(cx,cy,ax,ay);
  sides.w2 = edgeSide(ax,ay,bx,by);
  sides.sum = sides.w0 + sides.w1 + sides.w2;
  return sides;
}

/*! Whether no side rounded to 0, of a triangle that isInside: then their signs are exact. Least and greatest in the same
 *  order would become a branch, which a processor would not foresee. */
CVERT_REAL CVERT_INLINE CVERT_BOOL(Real) areCertain (CVERT_OF(TriangleSides) sides)
{
  return both(either(Real(0.0f) < lesser(sides.w0,lesser(sides.w1,sides.w2)),greater(greater(sides.w0,sides.w1),sides.w2) < Real(0.0f)),
              magnitude(sides.sum) < Real(infinity));
}

/* --- containment --------------------------------------------------------------------- */

/*! Exact sign of ax by - ay bx, in integers: the mantissas' products, shifted until their highest bits are at the same
 *  place, and their exponents. For finite numbers. */
struct ExactProduct
{
  int exponent;
  uint32_t high, low; //!< 24 bits each; 0 of a product that is 0
  bool isNegative;
};

CVERT_FUNCTION ExactProduct exactProduct (float a, float b)
{
  uint32_t s = bitsOfFloat(a), t = bitsOfFloat(b);
  uint32_t m = s & 0x7FFFFFu, n = t & 0x7FFFFFu;
  int e = int((s >> 23) & 255u), f = int((t >> 23) & 255u);
  if (e != 0) m |= 0x800000u; else e = 1;
  if (f != 0) n |= 0x800000u; else f = 1;

  /* halves of 12 bits */
  uint32_t cross = (m >> 12)*(n & 4095u) + (m & 4095u)*(n >> 12);
  uint32_t low = (m & 4095u)*(n & 4095u) + ((cross & 4095u) << 12);
  ExactProduct p;
  p.high = (m >> 12)*(n >> 12) + (cross >> 12) + (low >> 24);
  p.low = low & 0xFFFFFFu;
  p.exponent = e + f;
  p.isNegative = ((s ^ t) >> 31) != 0u;
  if ((p.high | p.low) == 0u) {
    p.exponent = 0;
    p.isNegative = false;
    return p;
  }
  for (int i=0; i<47 && (p.high & 0x800000u) == 0u; i++) {
    p.high = (p.high << 1) | (p.low >> 23);
    p.low = (p.low << 1) & 0xFFFFFFu;
    p.exponent--;
  }
  return p;
}

/*! sign of |p| - |q| */
CVERT_FUNCTION int compareMagnitudes (ExactProduct p, ExactProduct q)
{
  bool isZeroP = (p.high | p.low) == 0u, isZeroQ = (q.high | q.low) == 0u;
  if (isZeroP || isZeroQ) return isZeroP ? (isZeroQ ? 0 : -1) : 1;
  if (p.exponent != q.exponent) return p.exponent < q.exponent ? -1 : 1;
  if (p.high != q.high) return p.high < q.high ? -1 : 1;
  if (p.low != q.low) return p.low < q.low ? -1 : 1;
  return 0;
}

CVERT_FUNCTION int exactSideOfFloats (float ax, float ay, float bx, float by)
{
  ExactProduct p = exactProduct(ax,by), q = exactProduct(ay,bx);
  if (p.isNegative == q.isNegative) return p.isNegative ? -compareMagnitudes(p,q) : compareMagnitudes(p,q);
  return p.isNegative ? -1 : 1; // 0 is not negative, so the other is not 0
}

#if !defined(VULKAN) || defined(CBVH_FLOAT64)
/*! the same by doubles, in which products of floats are exact */
CVERT_FUNCTION int exactSide (float ax, float ay, float bx, float by)
{
  double p = double(ax)*double(by), q = double(ay)*double(bx);
  return p > q ? 1 : p < q ? -1 : 0;
}
#else
CVERT_FUNCTION int exactSide (float ax, float ay, float bx, float by) { return exactSideOfFloats(ax,ay,bx,by); }
#endif

/*! Whether a sheared triangle has the ray in it, by exact signs. Sides of 0 count for both of their triangles, and slivers,
 *  which have no others. A triangle whose three sides are 0 is a line, and covers nothing that others do not. */
CVERT_FUNCTION bool contains (float ax, float ay, float bx, float by, float cx, float cy)
{
  float size = magnitude(ax) + magnitude(ay) + magnitude(bx) + magnitude(by) + magnitude(cx) + magnitude(cy);
  if (!(size < infinity)) return false; // of a vertex that is not finite
  int s0 = exactSide(bx,by,cx,cy), s1 = exactSide(cx,cy,ax,ay), s2 = exactSide(ax,ay,bx,by);
  bool isPositive = s0 > 0 || s1 > 0 || s2 > 0, isNegative = s0 < 0 || s1 < 0 || s2 < 0;
  return isPositive != isNegative;
}

/* --- distance ------------------------------------------------------------------------ */

/*! A triangle's vertices along one axis each: at[axis][vertex]. Differences of floats are exact in double: weights of a needle
 *  are off by more than its plane is. */
CVERT_WIDE struct WideTriangle { Wide at[3][3]; };

/*! cross product of the edges from the first vertex; 0 of a line */
CVERT_WIDE struct WideNormal { Wide at[3]; };

CVERT_WIDE CVERT_INLINE CVERT_OF_WIDE(WideNormal) normalOf (CVERT_OF_WIDE(WideTriangle) triangle)
{
  Wide e[3], f[3];
  for (int k=0; k<3; k++) {
    e[k] = triangle.at[k][1] - triangle.at[k][0];
    f[k] = triangle.at[k][2] - triangle.at[k][0];
  }
  CVERT_OF_WIDE(WideNormal) n;
  n.at[0] = product(e[1],f[2]) - product(e[2],f[1]);
  n.at[1] = product(e[2],f[0]) - product(e[0],f[2]);
  n.at[2] = product(e[0],f[1]) - product(e[1],f[0]);
  return n;
}

/*! Below this a ray is taken to lie in the plane, as far as vertices of 24 bits can say. */
CVERT_CONSTANT float minCosine = 1e-6f;

/*! where a ray meets a plane */
CVERT_WIDE struct PlaneMeeting
{
  Wide t;            //!< not a number where the ray is parallel to the plane
  Wide speed, least; //!< a ray that comes nearer to the plane no faster than `least` lies in it
};

CVERT_WIDE CVERT_INLINE CVERT_OF_WIDE(PlaneMeeting) meetPlane (CVERT_OF_WIDE(WideTriangle) triangle, CVERT_OF_WIDE(WideNormal) normal, const Wide org[3], const Wide dir[3])
{
  Wide height = Wide(0.0f), speed = Wide(0.0f), size = Wide(0.0f);
  for (int k=0; k<3; k++) {
    Wide along = product(normal.at[k],dir[k]);
    speed = speed + along;
    size = size + magnitude(along);
    height = height + product(normal.at[k],triangle.at[k][0] - org[k]);
  }
  CVERT_OF_WIDE(PlaneMeeting) at;
  at.t = height/speed;
  at.speed = speed;
  at.least = Wide(minCosine)*size;
  return at;
}

/*! distances between which a triangle is along a ray: of its nearest and its farthest vertex */
CVERT_WIDE struct TriangleSpan { Wide nearest, farthest; };

/*! z0, z1, z2: of the vertices on the axis of the ray's largest component; org, dir: of the ray there. Division is monotonic, so
 *  that of the lowest and the highest is enough. */
CVERT_WIDE CVERT_INLINE CVERT_OF_WIDE(TriangleSpan) spanOf (Wide z0, Wide z1, Wide z2, Wide org, Wide dir)
{
  Wide d0 = z0-org, d1 = z1-org, d2 = z2-org;
  Wide a = lesser(d0,lesser(d1,d2))/dir, b = greater(greater(d0,d1),d2)/dir;
  CVERT_OF_WIDE(TriangleSpan) span;
  span.nearest = lesser(a,b);
  span.farthest = greater(b,a);
  return span;
}

CVERT_WIDE CVERT_INLINE Wide clampToSpan (CVERT_OF_WIDE(TriangleSpan) span, Wide t) { return lesser(greater(t,span.nearest),span.farthest); }

/*! Whether the plane gives the distance: the ray does not lie in it, or the plane's distance is within the triangle. Else
 *  the ray may be inside by the rounding of vertices alone, and the plane does not say where. */
CVERT_WIDE CVERT_INLINE CVERT_BOOL(Wide) isOfPlane (CVERT_OF_WIDE(PlaneMeeting) at, CVERT_OF_WIDE(TriangleSpan) span) {
  return either(at.least < magnitude(at.speed),both(span.nearest <= at.t,at.t <= span.farthest));
}

/*! where a ray is nearest to the longest edge of a triangle */
CVERT_WIDE CVERT_FUNCTION Wide alongLongestEdge (CVERT_OF_WIDE(WideTriangle) triangle, const Wide org[3], const Wide dir[3])
{
  Wide best = Wide(-1.0f), t = Wide(0.0f);
  for (int i=0; i<3; i++)
  {
    int j = i == 2 ? 0 : i+1;
    Wide ee = Wide(0.0f), dd = Wide(0.0f), de = Wide(0.0f), dw = Wide(0.0f), ew = Wide(0.0f);
    for (int k=0; k<3; k++)
    {
      Wide e = triangle.at[k][j] - triangle.at[k][i], w = triangle.at[k][i] - org[k], d = dir[k];
      ee += e*e; dd += d*d; de += d*e; dw += d*w; ew += e*w;
    }
    if (ee <= best) continue;
    best = ee;
    Wide det = dd*ee - de*de;
    Wide s = det > Wide(0.0f) ? lesser(greater((de*dw - dd*ew)/det,Wide(0.0f)),Wide(1.0f)) : Wide(0.0f); // along the edge
    t = (dw + s*de)/dd;
  }
  return t;
}

/*! Distance of the hit of a ray whose line goes through a triangle, and which may begin at tnear. A ray that lies in the plane,
 *  and of which the plane does not say where it is within the triangle, hits it where it is nearest to the longest edge, but
 *  not before it begins: it would leave a closed surface there without a hit. */
CVERT_WIDE CVERT_FUNCTION Wide distanceOfHit (CVERT_OF_WIDE(WideTriangle) triangle, CVERT_OF_WIDE(WideNormal) normal, CVERT_OF_WIDE(TriangleSpan) span,
                                            const Wide org[3], const Wide dir[3], Wide tnear)
{
  CVERT_OF_WIDE(PlaneMeeting) at = meetPlane(triangle,normal,org,dir);
  if (CVERT_LIKELY(isOfPlane(at,span))) return clampToSpan(span,at.t);
  Wide t = clampToSpan(span,alongLongestEdge(triangle,org,dir));
  return tnear <= span.farthest ? greater(t,tnear) : t;
}

/* --- nearest hit --------------------------------------------------------------------- */

/* whether a hit counts: see placeOfHit */
CVERT_CONSTANT uint32_t hitIsOutside = 0u; //!< it does not
CVERT_CONSTANT uint32_t hitIsNearest = 1u; //!< it does
CVERT_CONSTANT uint32_t hitIsTied = 2u;    //!< it does if it comesBefore the hit that the ray has

/*! exact: distance of the hit; tfar: the ray's, or the distance of the nearest hit so far; isOfHit: whether that is
 *  one of cVERT */
CVERT_WIDE CVERT_INLINE uint32_t placeOfHit (Wide exact, float tnear, float tfar, bool isOfHit)
{
  float t = float(exact);
  uint32_t farther = isOfHit ? (t == tfar ? hitIsTied : hitIsOutside)
                             : (exact <= Wide(tfar) ? hitIsNearest : hitIsOutside);
  return !(exact >= Wide(tnear)) ? hitIsOutside : CVERT_LIKELY(t < tfar) ? hitIsNearest : farther;
}

/*! which triangle of a scene it is */
struct TriangleName
{
  uint32_t geomID, primID;
  uint32_t region;     //!< of the block: VertHeader
  uint32_t triangle;  //!< of the block: 32 times its group's column + 4 row, 2 times its quad's column + 4 row, and 0 or 1
};

/*! Of hits at the same distance the one counts that comes before all others: so the order in which blocks are traced does not
 *  matter. */
CVERT_FUNCTION bool comesBefore (TriangleName a, TriangleName b)
{
  if (a.geomID != b.geomID) return a.geomID < b.geomID;
  if (a.primID != b.primID) return a.primID < b.primID;
  return a.region != b.region ? a.region < b.region : a.triangle < b.triangle;
}

/*! corner of the quad that is a vertex of triangle h of a group: column + 2 row */
CVERT_FUNCTION uint32_t cornerOfTriangle (uint32_t h, int vertex)
{
  bool isSecond = (h & 1u) != 0u;
  return vertex == 0 ? (isSecond ? 2u : 0u) : vertex == 1 ? 1u : (isSecond ? 3u : 2u);
}

/*! quad of triangle h in its group */
CVERT_FUNCTION uint32_t quadXOfTriangle (uint32_t h) { return (h >> 1) & 3u; }
CVERT_FUNCTION uint32_t quadYOfTriangle (uint32_t h) { return h >> 3; }

/* --- parameters ---------------------------------------------------------------------- */

/*! position in a quad, from 0 to 1 along u and v */
CVERT_REAL struct QuadPosition { Real a, b; };

CVERT_REAL CVERT_INLINE CVERT_OF(QuadPosition) positionInQuad (CVERT_OF(TriangleSides) sides, CVERT_BOOL(Real) isSecond)
{
  Real b1 = sides.w1/sides.sum, b2 = sides.w2/sides.sum; // weights of the second and the third vertex; not numbers where all sides rounded to 0
  CVERT_OF(QuadPosition) position;
  position.a = choose(isSecond,b1+b2,b1);
  position.b = choose(isSecond,Real(1.0f)-b1,b2);
  return position;
}

/*! what is not a number, of slivers, becomes the middle of the diagonal: both triangles have it */
CVERT_REAL CVERT_INLINE Real inUnit (Real x) {
  return choose(x >= Real(0.0f),lesser(x,Real(1.0f)),choose(x < Real(0.0f),Real(0.0f),Real(0.5f)));
}

/*! A parameter of the face, at position a of quad x, of as many along the patch. corner: the patch's, in halves */
CVERT_REAL CVERT_INLINE Real faceParameterOfQuad (uint32_t corner, Real x, Real a, uint32_t quads) {
  return Real(0.5f*float(corner)) + greater((x + inUnit(a))/Real(float(quads)),Real(0.0f));
}

/*! quad of the patch that is the first of the group in a lane */
CVERT_FUNCTION uint32_t firstQuadX (uint32_t region, uint32_t lane) { return vertX(region) + groupQuads*(lane & 3u); }
CVERT_FUNCTION uint32_t firstQuadY (uint32_t region, uint32_t lane) { return vertY(region) + groupQuads*(lane >> 2); }

/*! whether an edge of a patch has a lower rate than its quads, of a block that has edges */
CVERT_FUNCTION bool hasLowerEdge (uint32_t patchQuads, VertEdges edges)
{
  uint32_t quadsX = patchQuadsX(patchQuads), quadsY = patchQuadsY(patchQuads);
  return vertRate(edges,0) != quadsX || vertRate(edges,1) != quadsY || vertRate(edges,2) != quadsX || vertRate(edges,3) != quadsY;
}

/*! Whether a quad of a patch, of a block that has edges, is at one of a lower rate: its parameters are interpolated from its
 *  vertices'. */
CVERT_FUNCTION bool isAtLowerEdge (uint32_t patchQuads, VertEdges edges, uint32_t x, uint32_t y)
{
  uint32_t quadsX = patchQuadsX(patchQuads), quadsY = patchQuadsY(patchQuads);
  return (y == 0u && vertRate(edges,0) != quadsX) || (x+1u == quadsX && vertRate(edges,1) != quadsY)
    || (y+1u == quadsY && vertRate(edges,2) != quadsX) || (x == 0u && vertRate(edges,3) != quadsY);
}

struct FaceParameters { float u, v; };

/*! of position (a,b) of such a quad: barycentrics in a triangle, of parameters that Embree stitches where an edge has a lower rate */
CVERT_FUNCTION FaceParameters parametersAtLowerEdge (uint32_t patchQuads, VertEdges edges, uint32_t x, uint32_t y, bool isSecond, float a, float b)
{
  uint32_t quadsX = patchQuadsX(patchQuads), quadsY = patchQuadsY(patchQuads);
  float p = inUnit(a), q = inUnit(b), s = 0.0f, t = 0.0f;
  for (uint32_t c=0u; c<4u; c++)
  {
    float w = c == 0u ? (isSecond ? 0.0f : 1.0f-p-q) : c == 1u ? (isSecond ? 1.0f-q : p) : c == 2u ? (isSecond ? 1.0f-p : q) : (isSecond ? p+q-1.0f : 0.0f);
    uint32_t i = x + (c & 1u), j = y + (c >> 1);
    s += w*CVERT_AS_FLOAT(vertParameter)(i,quadsX,j == 0u ? vertRate(edges,0) : j == quadsY ? vertRate(edges,2) : quadsX);
    t += w*CVERT_AS_FLOAT(vertParameter)(j,quadsY,i == 0u ? vertRate(edges,3) : i == quadsX ? vertRate(edges,1) : quadsY);
  }
  FaceParameters parameters;
  parameters.u = 0.5f*float(vertCornerU(edges)) + greater(s,0.0f);
  parameters.v = 0.5f*float(vertCornerV(edges)) + greater(t,0.0f);
  return parameters;
}

/*! What a hit says of the surface: the primitive, and the parameters there. */
struct SurfacePoint
{
  uint32_t primID;
  float u, v;
};

/*! In a block that numbers its quads; h: triangle of the group in a lane. */
CVERT_INLINE SurfacePoint pointOfNumberedQuad (CVERT_POINTER(VertHeader) block, uint32_t lane, uint32_t h,
                                               CVERT_AS_FLOAT(QuadPosition) at)
{
  uint32_t x = groupQuads*(lane & 3u) + quadXOfTriangle(h), y = groupQuads*(lane >> 2) + quadYOfTriangle(h);
  bool isSecond = (h & 1u) != 0u;
  QuadPrimitive primitive = primitiveOfQuad(block,x,y,isSecond);
  OwnParameters own = ownParameters(primitive.form,isSecond,inUnit(at.a),inUnit(at.b));
  SurfacePoint point;
  point.primID = primitive.primID;
  point.u = own.u;
  point.v = own.v;
  return point;
}

/*! In a block of a patch. */
CVERT_INLINE SurfacePoint pointOfPatch (CVERT_POINTER(VertHeader) block, uint32_t lane, uint32_t h,
                                        CVERT_AS_FLOAT(QuadPosition) at)
{
  uint32_t patchQuads = CVERT_AT(VertHeader,block).patchQuads, region = CVERT_AT(VertHeader,block).region;
  uint32_t x = firstQuadX(region,lane) + quadXOfTriangle(h), y = firstQuadY(region,lane) + quadYOfTriangle(h);
  uint32_t cornerU = 0u, cornerV = 0u;
  SurfacePoint point;
  point.primID = CVERT_AT(VertHeader,block).primID;
  if (!CVERT_LIKELY(!hasEdges(CVERT_AT(VertHeader,block).boxForm)))
  {
    VertEdges edges = edgesOf(block);
    if (isAtLowerEdge(patchQuads,edges,x,y)) {
      FaceParameters parameters = parametersAtLowerEdge(patchQuads,edges,x,y,(h & 1u) != 0u,at.a,at.b);
      point.u = parameters.u;
      point.v = parameters.v;
      return point;
    }
    cornerU = vertCornerU(edges);
    cornerV = vertCornerV(edges);
  }
  point.u = faceParameterOfQuad(cornerU,float(x),at.a,patchQuadsX(patchQuads));
  point.v = faceParameterOfQuad(cornerV,float(y),at.b,patchQuadsY(patchQuads));
  return point;
}

CVERT_INLINE SurfacePoint surfacePoint (CVERT_POINTER(VertHeader) block, uint32_t lane, uint32_t h,
                                        CVERT_AS_FLOAT(QuadPosition) at)
{
  if (hasNumbers(CVERT_AT(VertHeader,block).boxForm)) return pointOfNumberedQuad(block,lane,h,at);
  return pointOfPatch(block,lane,h,at);
}

CVERT_END

#endif
