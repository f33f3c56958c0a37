// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays that start just inside a closed surface and leave it at a grazing angle, as with a renderer's tiny offset.
 * Doubles decide: a ray with an odd number of crossings starts inside and must hit. */

#include "support/random.h"
#include "support/scene.h"
#include "support/vert_triangles.h"

#include <algorithm>
#include <cmath>

namespace programs::test { namespace {

// Rotated, so that no face is aligned to an axis.
Cage turned(Cage cage) {
  const float c = std::cos(0.7f), s = std::sin(0.7f), d = std::cos(0.4f), e = std::sin(0.4f);
  for (Vec& p : cage.positions) {
    const Vec q = {c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
    p = {q[0], d * q[1] - e * q[2], e * q[1] + d * q[2]};
  }
  return cage;
}

// A point inside the triangle, away from edges and corners.
std::array<double, 3> pointIn(const VertTriangle& t, Random& random) {
  double w[3], sum = 0;
  for (double& x : w) sum += x = random.uniform(0.05, 1);
  std::array<double, 3> p = {};
  for (int c = 0; c < 3; c++)
    for (int k = 0; k < 3; k++) p[k] += w[c] / sum * t.vertices[c][k];
  return p;
}

// Number of times that a ray crosses the surface after its start; -1 if that is ambiguous.
int crossings(const std::vector<VertTriangle>& triangles, const RTCRay& ray) {
  int n = 0;
  for (const VertTriangle& triangle : triangles) {
    ExactHit hit;
    if (!triangle.hasArea() || !meet(ray, triangle, hit)) continue;
    if (inside(hit) < -1e-6 || hit.t < -1e-9) continue;
    if (inside(hit) < 1e-6 || hit.t < 1e-9) return -1;
    n++;
  }
  return n;
}

TEST(NearStarts, RaysFromNearATriangleLeaveThroughIt) {
  Device device;
  const struct {
    const char* name;
    Cage cage;
  } solids[] = {{"cube", turned(cubeCage())}, {"prism", turned(prismCage(3))}};
  for (const auto& solid : solids)
    for (float maxError : {0.0f, 0.3f}) { // also lattices coarser than the quads
      SurfaceSettings settings;
      settings.compression = RTC_COMPRESSION_CVERT;
      settings.rate = maxError > 0 ? 8 : 2;
      settings.maxError = maxError;
      const SurfaceScene scene(device, solid.cage, settings);
      const std::vector<VertTriangle> triangles = vertTriangles(scene);
      Random random(104);
      size_t leaving = 0, lost = 0, lostByAnyHit = 0;
      for (double distance : {1e-4, 1e-5, 1e-6, 1e-7, 1e-8})
        for (int n = 0; n < 20000; n++) {
          const VertTriangle& at = triangles[random.below(unsigned(triangles.size()))];
          if (!at.hasArea()) continue;
          const std::array<double, 3> from = pointIn(at, random), to = pointIn(at, random);
          double a[3], b[3], normal[3], length2 = 0;
          for (int k = 0; k < 3; k++) {
            a[k] = double(at.vertices[1][k]) - at.vertices[0][k];
            b[k] = double(at.vertices[2][k]) - at.vertices[0][k];
          }
          for (int k = 0; k < 3; k++) {
            normal[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
            length2 += normal[k] * normal[k];
          }
          if (!(length2 > 0)) continue;
          // distance from the surface relative to the size of the triangle, about the square root of its area
          const double depth = distance * std::pow(length2, 0.25) / std::sqrt(length2);
          Vec org, dir;
          for (int k = 0; k < 3; k++) {
            org[k] = float(from[k] - depth * normal[k]);
            dir[k] = float(to[k] - org[k]);
          }
          RTCRayHit query = makeRay(org, dir);
          const RTCRay& ray = query.ray;
          if (crossings(triangles, ray) % 2 != 1) continue;
          leaving++;
          RTCRay any = ray;
          RTCIntersectContext context;
          rtcInitIntersectContext(&context);
          rtcIntersect1(scene, &context, &query);
          rtcOccluded1(scene, &context, &any);
          lost += query.hit.geomID == RTC_INVALID_GEOMETRY_ID;
          lostByAnyHit += any.tfar >= 0;
        }
      EXPECT_GT(leaving, 10000u) << solid.name;
      EXPECT_EQ(lost, 0u) << solid.name << ", of " << leaving << ", requested spacing " << maxError;
      EXPECT_EQ(lostByAnyHit, 0u) << solid.name;
    }
}

}} // namespace programs::test
