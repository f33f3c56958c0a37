// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Embree's triangle tests, with the same order of operations: Pluecker coordinates for grids and robust scenes,
 * otherwise Moeller and Trumbore's test. */

#ifndef CBVH_TRIANGLE_GLSL
#define CBVH_TRIANGLE_GLSL

#include "ray.glsl"

/* Vertex i of a grid, whose x, y and z are arrays of `plane` words from word `first` on. */
vec3 cbvhGridVertex(CbvhPointer block, uint first, uint plane, uint i) {
  return vec3(cbvhFloat(block, first + i), cbvhFloat(block, first + plane + i),
              cbvhFloat(block, first + 2u * plane + i));
}

/* Indices of a triangle of the quad with vertex 00 at index i: 00, 10, 01, or 01, 10, 11 for the second one. width:
 * vertices per row. */
uvec3 cbvhQuadTriangle(uint i, uint width, bool second) {
  return second ? uvec3(i + width, i + 1u, i + width + 1u) : uvec3(i, i + 1u, i + width);
}

struct CbvhTriangleHit {
  float t;
  float u, v; // weights of the second and third vertex
  vec3 Ng;
};

/* Normal from the edges of a triangle. Uses the pair of edges with less cancellation on each axis, as in Embree. */
vec3 cbvhStableNormal(vec3 a, vec3 b, vec3 c) {
  vec3 ab = a.zxy * b.yzx, bc = b.zxy * c.yzx;
  vec3 crossAB = a.yzx * b.zxy - ab, crossBC = b.yzx * c.zxy - bc;
  return mix(crossBC, crossAB, lessThan(abs(ab), abs(bc)));
}

/* Side of the ray on which an edge lies: dot(cross(edge, sum), dir). The edge's other triangle, with the edge in the
 * other direction, gets the exact negative, because all three edges are computed without fused operations. */
float cbvhPlueckerSide(vec3 edge, vec3 sum, vec3 dir) {
  precise vec3 plus = edge.yzx * sum.zxy, minus = edge.zxy * sum.yzx;
  precise vec3 products = (plus - minus) * dir;
  precise float side = products.x + products.y + products.z;
  return side;
}

bool cbvhPluecker(CbvhPreparedRay ray, float tfar, vec3 a, vec3 b, vec3 c, out CbvhTriangleHit hit) {
  precise vec3 v0 = a - ray.org, v1 = b - ray.org, v2 = c - ray.org;
  precise vec3 e0 = v2 - v0, e1 = v0 - v1, e2 = v1 - v2;
  precise vec3 s0 = v2 + v0, s1 = v0 + v1, s2 = v1 + v2;
  float U = cbvhPlueckerSide(e0, s0, ray.dir), V = cbvhPlueckerSide(e1, s1, ray.dir),
        W = cbvhPlueckerSide(e2, s2, ray.dir);
  float UVW = U + V + W, eps = floatUlp * abs(UVW);
  if (!(min(U, min(V, W)) >= -eps || max(U, max(V, W)) <= eps)) return false;
  vec3 Ng = cbvhStableNormal(e0, e1, e2);
  float den = 2.0 * dot(Ng, ray.dir), t = 2.0 * dot(v0, Ng) / den;
  if (!(ray.tnear <= t && t <= tfar) || den == 0.0) return false;
  float rcpUVW = abs(UVW) < 1e-18 ? 0.0 : 1.0 / UVW;
  hit = CbvhTriangleHit(t, min(U * rcpUVW, 1.0), min(V * rcpUVW, 1.0), Ng);
  return true;
}

bool cbvhMoellerTrumbore(CbvhPreparedRay ray, float tfar, vec3 a, vec3 b, vec3 c, out CbvhTriangleHit hit) {
  vec3 e1 = a - b, e2 = c - a, Ng = cross(e2, e1), C = a - ray.org, R = cross(C, ray.dir);
  float den = dot(Ng, ray.dir), absDen = abs(den), sgn = den < 0.0 ? -1.0 : 1.0;
  float U = dot(R, e2) * sgn, V = dot(R, e1) * sgn;
  if (!(den != 0.0 && U >= 0.0 && V >= 0.0 && U + V <= absDen)) return false;
  float T = dot(Ng, C) * sgn;
  if (!(absDen * ray.tnear < T && T <= absDen * tfar)) return false;
  float rcp = 1.0 / absDen;
  hit = CbvhTriangleHit(T * rcp, U * rcp, V * rcp, Ng);
  return true;
}

#endif
