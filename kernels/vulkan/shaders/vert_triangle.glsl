// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Intersects a ray with a triangle of a cVERT block or mesh block by kernels/cvert/rule/rule.h. */

#ifndef CBVH_VERT_TRIANGLE_GLSL
#define CBVH_VERT_TRIANGLE_GLSL

#include "ray.glsl"
#include "../../cvert/rule/rule.h"

/* The shear that maps the ray's direction to axis kz, the axis of its largest component. */
struct CbvhShear {
  int kz;
  float sx, sy;
};

/* Rotates the components so that kz is last. */
vec3 cbvhPermuteAxes(int kz, vec3 v) { return kz == 2 ? v : kz == 0 ? v.yzx : v.zxy; }

CbvhShear cbvhShear(vec3 dir) {
  vec3 a = abs(dir);
  CbvhShear shear;
  shear.kz = largestAxis(a.x, a.y, a.z);
  vec3 d = cbvhPermuteAxes(shear.kz, dir);
  precise float sz = 1.0 / d.z; // the same rounding for all kinds of blocks
  precise vec2 slopes = d.xy * sz;
  shear.sx = slopes.x;
  shear.sy = slopes.y;
  return shear;
}

/* Position of a vertex relative to the ray, perpendicular to axis kz. The ray passes through (0,0). */
vec2 cbvhSheared(CbvhShear shear, vec3 org, vec3 vertex) {
  precise vec3 r = cbvhPermuteAxes(shear.kz, vertex - org);
  precise vec2 products = vec2(shear.sx * r.z, shear.sy * r.z);
  precise vec2 at = r.xy - products;
  return at;
}

float cbvhEdgeSide(vec2 a, vec2 b) { return edgeSide(a.x, a.y, b.x, b.y); }

WideTriangle cbvhWideTriangle(vec3 a, vec3 b, vec3 c) {
  WideTriangle triangle;
  for (int k = 0; k < 3; k++) {
    triangle.at[k][0] = Wide(a[k]);
    triangle.at[k][1] = Wide(b[k]);
    triangle.at[k][2] = Wide(c[k]);
  }
  return triangle;
}

/* The nearest hit in cVERT triangles. `key` orders hits at the same distance, see hasPrecedence. */
struct CbvhVertNearest {
  bool isSet;
  uint instID;
  float t;
  TriangleKey key;
};

CbvhVertNearest cbvhNoVertNearest() { return CbvhVertNearest(false, 0u, 0.0, TriangleKey(0u, 0u, 0u, 0u)); }

struct CbvhVertHit {
  float t;
  TriangleSides sides;
  vec3 Ng;
};

/* Returns true and sets `nearest` if the ray hits the triangle and the hit counts, see classifyHit. tfar: end of the
 * ray, or distance of its nearest hit of any kind. */
bool cbvhIntersectTriangle(CbvhPreparedRay ray, CbvhShear shear, vec3 a, vec3 b, vec3 c, TriangleKey key, float tfar,
                           inout CbvhVertNearest nearest, out CbvhVertHit at) {
  vec2 A = cbvhSheared(shear, ray.org, a), B = cbvhSheared(shear, ray.org, b), C = cbvhSheared(shear, ray.org, c);
  at.sides = triangleSides(A.x, A.y, B.x, B.y, C.x, C.y);
  if (!haveExactSigns(at.sides) && !contains(A.x, A.y, B.x, B.y, C.x, C.y)) return false;

  WideTriangle triangle = cbvhWideTriangle(a, b, c);
  WideNormal normal = normalOf(triangle);
  int kz = shear.kz;
  Wide org[3], dir[3];
  for (int k = 0; k < 3; k++) {
    org[k] = Wide(ray.org[k]);
    dir[k] = Wide(ray.dir[k]);
  }
  TriangleSpan span = spanOf(triangle.at[kz][0], triangle.at[kz][1], triangle.at[kz][2], org[kz], dir[kz]);
  Wide distance = distanceOfHit(triangle, normal, span, org, dir, Wide(ray.tnear));
  bool isHitDistance = nearest.isSet && nearest.t == tfar && nearest.instID == ray.instID;
  uint result = classifyHit(distance, ray.tnear, tfar, isHitDistance);
  if (result == hitIsOutOfRange || (result == hitIsTied && !hasPrecedence(key, nearest.key))) return false;

  at.t = float(distance);
  at.Ng = vec3(normal.at[0], normal.at[1], normal.at[2]);
  if (at.Ng == vec3(0.0)) at.Ng = -ray.dir;
  nearest = CbvhVertNearest(true, ray.instID, at.t, key);
  return true;
}

/* --- triangles of quads ---------------------------------------------------------------- */

/* Returns a mask of the triangles of four quads in a row that the ray's line may pass through: bits 2i and 2i + 1 for
 * quad i. below, above: sheared vertices. */
uint cbvhRowTriangles(vec2 below[5], vec2 above[5]) {
  uint mask = 0u;
  [[unroll]] for (uint i = 0u; i < 4u; i++) {
    float diag = cbvhEdgeSide(below[i + 1u], above[i]), left = cbvhEdgeSide(above[i], below[i]),
          bottom = cbvhEdgeSide(below[i], below[i + 1u]);
    float right = cbvhEdgeSide(below[i + 1u], above[i + 1u]), top = cbvhEdgeSide(above[i + 1u], above[i]);
    if (mayContain(diag, left, bottom)) mask |= 1u << (2u * i);
    if (mayContain(right, top, -diag)) mask |= 2u << (2u * i);
  }
  return mask;
}

/* Tests a triangle of a block or tile exactly. lane: of its group, and index: of the triangle in the group, as in
 * rule.h. mayBeInvalid: whether vertices may be not finite. */
bool cbvhIntersectQuadTriangle(uvec2 block, uint geomID, CbvhPreparedRay ray, CbvhShear shear, uint lane, uint index,
                               vec3 a, vec3 b, vec3 c, bool mayBeInvalid, inout CbvhHit hit,
                               inout CbvhVertNearest nearest) {
  if (mayBeInvalid && !(cbvhIsFinite(a) && cbvhIsFinite(b) && cbvhIsFinite(c))) return false;
  TriangleKey key =
      TriangleKey(geomID, CVERT_AT(VertHeader, block).primID, CVERT_AT(VertHeader, block).region, 32u * lane + index);
  CbvhVertHit at;
  if (!cbvhIntersectTriangle(ray, shear, a, b, c, key, hit.t, nearest, at)) return false;
  SurfacePoint point = surfacePoint(block, lane, index, positionInQuad(at.sides, (index & 1u) != 0u));
  cbvhSetHit(hit, ray, at.t, point.u, point.v, at.Ng, point.primID, geomID);
  return true;
}

#endif
