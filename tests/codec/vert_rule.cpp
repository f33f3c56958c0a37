// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cVERT's intersection rule: arithmetic without 64-bit floats has the results of doubles, and one of any two hits
 * precedes the other. */

#include "kernels/cvert/rule/rule.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace programs::test { namespace {

using namespace cvert;

// Every second is similar to `like` or -`like`, so that products are nearly or exactly equal.
float drawn(Random& random, float like) {
  switch (random.below(6)) {
  case 0: return like;
  case 1: return std::nextafter(like, random.chance(0.5) ? INFINITY : -INFINITY);
  case 2: return -like;
  case 3: return float(int(random.below(9)) - 4);
  case 4: return std::ldexp(float(random.uniform(-1, 1)), int(random.below(250)) - 149); // includes denormals
  default: return float(random.uniform(-1, 1));
  }
}

TEST(VertRule, IntegerSignsMatchDoubles) {
  Random random(101);
  std::array<size_t, 3> found = {};
  for (int n = 0; n < 2000000; n++) {
    float x[4];
    x[0] = drawn(random, 1);
    for (int i = 1; i < 4; i++) x[i] = drawn(random, x[i - 1]);
    if (!std::all_of(x, x + 4, [](float f) { return std::isfinite(f); })) continue;
    const double side = double(x[0]) * double(x[3]) - double(x[1]) * double(x[2]);
    const int expected = side > 0 ? 1 : side < 0 ? -1 : 0;
    ASSERT_EQ(exactSideOfFloats(x[0], x[1], x[2], x[3]), expected) << x[0] << " " << x[1] << " " << x[2] << " " << x[3];
    ASSERT_EQ(exactSide(x[0], x[1], x[2], x[3]), expected);
    found[expected + 1]++;
  }
  for (size_t n : found) EXPECT_GT(n, 100000u);
}

// Vertices on an integer grid, computed with integers.
TEST(VertRule, EdgesBelongToBothTriangles) {
  Random random(102);
  size_t inside = 0, onEdges = 0, lines = 0;
  for (int n = 0; n < 200000; n++) {
    int p[3][2];
    for (auto& v : p)
      for (int& c : v) c = int(random.below(9)) - 4;
    const auto cross = [&](int a, int b) { return p[a][0] * p[b][1] - p[a][1] * p[b][0]; };
    const int s[3] = {cross(1, 2), cross(2, 0), cross(0, 1)};
    const int least = *std::min_element(s, s + 3), greatest = *std::max_element(s, s + 3);
    const bool expected = (least >= 0 && greatest > 0) || (least < 0 && greatest <= 0);
    ASSERT_EQ(contains(p[0][0], p[0][1], p[1][0], p[1][1], p[2][0], p[2][1]), expected);
    ASSERT_EQ(contains(p[0][0], p[0][1], p[2][0], p[2][1], p[1][0], p[1][1]), expected) << "reversed";
    inside += least > 0 || greatest < 0;
    onEdges += expected && least <= 0 && greatest >= 0;
    lines += least == 0 && greatest == 0;
  }
  EXPECT_GT(inside, 10000u);
  EXPECT_GT(onEdges, 10000u);
  EXPECT_GT(lines, 1000u);
  EXPECT_FALSE(contains(NAN, 0, 1, 0, 0, 1));
  EXPECT_FALSE(contains(-1, -1, INFINITY, 0, 0, 1));
}

// A ray that is nearly parallel to the plane hits a triangle where it hits the plane, if that is within the
// triangle's span: here 1/1024 after or before its start, with exact doubles.
TEST(VertRule, DistanceWithinTheSpanIsThePlanes) {
  for (double tilt : {1.0, 1e-3, 1e-6, 1e-7, 1e-9, 1e-12})
    for (double start : {-1.0 / 1024, 1.0 / 1024}) {
      WideTriangle<double> triangle = {{{0, 4, 0}, {-1, 0, 1}, {0, 0, 0}}}; // in the plane z = 0
      // along x, through (1,0,0) at distance `start`
      const double org[3] = {1 - start, 0, -tilt * start}, dir[3] = {1, 0, tilt};
      const auto span = spanOf(triangle.at[0][0], triangle.at[0][1], triangle.at[0][2], org[0], dir[0]);
      EXPECT_NEAR(distanceOfHit(triangle, normalOf(triangle), span, org, dir, 0.0), start, 1e-9) << tilt;
    }
}

// A ray in the plane hits near the longest edge, but not before its start, unless the triangle is behind the start.
TEST(VertRule, RayInThePlaneHitsNearTheLongestEdge) {
  const WideTriangle<double> triangle = {{{0, 4, 0}, {-1, 0, 1}, {0, 0, 0}}};
  for (double x : {-3.0, 0.5, 2.0, 3.5, 5.0}) {
    const double org[3] = {x, 0.125, 0}, dir[3] = {1, 0, 0};
    const auto span = spanOf(triangle.at[0][0], triangle.at[0][1], triangle.at[0][2], org[0], dir[0]);
    const double t = distanceOfHit(triangle, normalOf(triangle), span, org, dir, 0.0);
    if (x > 4) EXPECT_LT(t, 0);
    else {
      EXPECT_GE(t, 0) << x;
      EXPECT_GE(x + t, 0);
      EXPECT_LE(x + t, 4);
    }
  }
}

// The plane's distance is valid there, and rays that start there hit.
TEST(VertRule, EndsOfTheSpanAreInclusive) {
  const TriangleSpan<double> span = {1, 5};
  for (double t : {1.0, 5.0}) EXPECT_TRUE(isPlaneDecisive(PlaneIntersection<double>{t, 0, 1}, span)) << t;
  for (double t : {0.999, 5.001}) EXPECT_FALSE(isPlaneDecisive(PlaneIntersection<double>{t, 0, 1}, span)) << t;

  const WideTriangle<double> triangle = {{{0, 4, 0}, {-1, 0, 1}, {0, 0, 0}}};
  const double org[3] = {-1, -0.5, 0}, dir[3] = {1, 0, 0}; // in its plane; closest to its longest edge at 3
  EXPECT_EQ(distanceOfHit(triangle, normalOf(triangle), span, org, dir, 5.0), 5.0);
}

TEST(VertRule, TriangleWithNonFiniteVertexContainsNothing) {
  for (float odd : {INFINITY, -INFINITY, NAN})
    for (int i = 0; i < 6; i++) {
      float x[6] = {-1, -1, 2, -1, -1, 2}; // around the ray
      EXPECT_TRUE(contains(x[0], x[1], x[2], x[3], x[4], x[5]));
      x[i] = odd;
      EXPECT_FALSE(contains(x[0], x[1], x[2], x[3], x[4], x[5])) << odd << " at " << i;
    }
}

// Sides of such triangles overflow, so that exact signs decide.
TEST(VertRule, FiniteVerticesOfAnySizeAreHit) {
  for (float scale : {1e-38f, 1.0f, 1e18f, 1e37f, 5e37f, 1e38f, 1.7e38f}) {
    const float one = scale, two = 2 * scale;
    const TriangleSides<float> sides = triangleSides(-one, -one, two, -one, -one, two);
    ASSERT_TRUE(mayContain(sides.w0, sides.w1, sides.w2)) << scale;
    EXPECT_TRUE(contains(-one, -one, two, -one, -one, two)) << scale;
    EXPECT_FALSE(contains(one, one, two, one, one, two)) << scale;
  }
}

// Between the parameters of the vertices, which match GRID's: vertex i of n quads has the parameter of vertex floor((i
// + 1/2) rate / n) of the edge.
TEST(VertRule, ParametersAtLowerEdgesAreInterpolated) {
  const uint32_t quads[2] = {7, 5}, rates[4] = {3, 2, 7, 4}; // v = 0, u = 1, v = 1, u = 0
  const VertEdges edges = packEdges(rates[0], rates[1], rates[2], rates[3], 1, 0);
  const auto parameter = [](uint32_t i, uint32_t n, uint32_t rate) { return std::floor((i + 0.5) * rate / n) / rate; };
  for (uint32_t y = 0; y < quads[1]; y++)
    for (uint32_t x = 0; x < quads[0]; x++)
      for (bool isSecond : {false, true})
        for (const auto& at : {std::array<double, 2>{0.125, 0.25}, {0.5, 0.25}, {0.25, 0.5}, {0, 0}, {1, 0}, {0, 1}}) {
          const double weight[3] = {1 - at[0] - at[1], at[0], at[1]};
          // the quad's corners 00, 10, 01, 11: the first triangle has 00, 10, 01, the second 11, 01, 10
          const int corners[3] = {isSecond ? 3 : 0, isSecond ? 2 : 1, isSecond ? 1 : 2};
          double u = 0.5, v = 0, a = 0, b = 0;
          for (int k = 0; k < 3; k++) {
            const uint32_t i = x + (corners[k] & 1), j = y + (corners[k] >> 1);
            u += weight[k] * parameter(i, quads[0], j == 0 ? rates[0] : j == quads[1] ? rates[2] : quads[0]);
            v += weight[k] * parameter(j, quads[1], i == 0 ? rates[3] : i == quads[0] ? rates[1] : quads[1]);
            a += weight[k] * (corners[k] & 1);
            b += weight[k] * (corners[k] >> 1);
          }
          const FaceParameters found =
              parametersAtStitchedEdge(packPatchQuads(quads[0], quads[1]), edges, x, y, isSecond, float(a), float(b));
          EXPECT_NEAR(found.u, u, 1e-6) << x << " " << y << " " << isSecond << " " << a << " " << b;
          EXPECT_NEAR(found.v, v, 1e-6) << x << " " << y << " " << isSecond << " " << a << " " << b;
        }
}

TEST(VertRule, OrderOfTwoTrianglesIsTotal) {
  Random random(103);
  const auto draw = [&] { return TriangleKey{random.below(2), random.below(2), random.below(2), random.below(3)}; };
  for (int n = 0; n < 10000; n++) {
    const TriangleKey a = draw(), b = draw(), c = draw();
    const bool isSame =
        a.geomID == b.geomID && a.primID == b.primID && a.region == b.region && a.triangle == b.triangle;
    EXPECT_EQ(hasPrecedence(a, b) + hasPrecedence(b, a), isSame ? 0 : 1);
    if (hasPrecedence(a, b) && hasPrecedence(b, c)) { EXPECT_TRUE(hasPrecedence(a, c)); }
    if (a.geomID < b.geomID) { EXPECT_TRUE(hasPrecedence(a, b)); }
  }
}

}} // namespace programs::test
