// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Crossing of a ray with a leaf (paper/leaf/crossing.h), compared with bisection, finite differences and dense
 * sampling in double precision. */

#include "kernels/cbvh/paper/leaf/crossing.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <vector>

namespace programs::test { namespace {

using namespace embree::cbvh;

constexpr int samples = 2000;

// --- independent methods -------------------------------------------------------------------

double bilinear(const LeafPatch& leaf, double u, double v) {
  const double lower = leaf.z[0] * (1 - u) + leaf.z[1] * u, upper = leaf.z[2] * (1 - u) + leaf.z[3] * u;
  return lower * (1 - v) + upper * v;
}

double clamped(double x) { return std::min(1.0, std::max(0.0, x)); }

double bisect(const Parabola<double>& f) {
  auto isBelow = [&](double k) { return (1 - k) * f.f0 + k * f.f1 + f.saddle * k * (1 - k) < 0; };
  double a = 0, b = 1;
  while (true) {
    const double middle = 0.5 * (a + b);
    if (middle <= a || middle >= b) return middle;
    (isBelow(middle) == isBelow(0) ? a : b) = middle;
  }
}

// Minimum over samples of [0,1].
template<typename Function>
double leastOf(const Function& function) {
  double least = 1e300;
  for (int i = 0; i <= samples; i++) least = std::min(least, function(double(i) / samples));
  return least;
}

// --- parabolas -----------------------------------------------------------------------------

// Small, large and nearly straight parabolas, and parabolas whose second root is near.
Parabola<double> randomParabola(Random& random) {
  Parabola<double> f;
  f.f0 = random.uniform(-1, 1) * random.magnitude(1e-6, 1);
  f.f1 = random.uniform(-1, 1) * random.magnitude(1e-6, 1);
  f.saddle = random.uniform(-1, 1) * random.magnitude(1e-9, 10);
  switch (random.below(8)) {
  case 0: f.saddle = 0; break;
  case 1: f.f0 = 0; break;
  case 2: f.f1 = 0; break;
  case 3: f.f1 = -f.f0; break;
  case 4: f.saddle = f.f0 - f.f1; break; // no linear term
  default: break;
  }
  return f;
}

double scaleOf(const Parabola<double>& f) { return std::max({std::fabs(f.f0), std::fabs(f.f1), std::fabs(f.saddle)}); }

TEST(Crossing, RootIsAtChangeOfSign) {
  Random random(41);
  unsigned changes = 0, farRoots = 0;
  for (int i = 0; i < 200000; i++) {
    const Parabola<double> f = randomParabola(random);
    if ((f.f0 < 0) == (f.f1 < 0)) continue;
    changes++;
    farRoots += std::fabs(f.saddle) > 2 * std::fabs(f.f1 - f.f0);
    SCOPED_TRACE(testing::Message() << "parabola " << f.f0 << " " << f.f1 << " " << f.saddle);
    const double k = parabolaRoot(f), expected = bisect(f);
    if (expected > 1 - 1e-6) continue; // covered by the next test
    ASSERT_GE(k, 0);
    ASSERT_LE(k, 1);
    // The error of nearly double roots is about the square root of double's rounding error. An end with f = 0 is a
    // root, too.
    if (f.f0 != 0 && f.f1 != 0) { ASSERT_NEAR(k, expected, 1e-6); }
    ASSERT_NEAR(parabolaAt(f, k), 0, 1e-14 * scaleOf(f));

    const float kFloat = parabolaRoot(Parabola<float>{float(f.f0), float(f.f1), float(f.saddle)});
    ASSERT_GE(kFloat, 0);
    ASSERT_LE(kFloat, 1);
    ASSERT_NEAR(parabolaAt(f, double(kFloat)), 0, 2e-6 * scaleOf(f));
  }
  EXPECT_GT(changes, 50000u);
  EXPECT_GT(farRoots, 10000u);
}

// Rounding may increase the root to more than 1.
TEST(Crossing, RootAtExitIsNotConfusedWithEntry) {
  Random random(49);
  for (int i = 0; i < 200000; i++) {
    Parabola<double> f = randomParabola(random);
    f.f0 = -std::fabs(f.f0);
    f.f1 = 0;
    ASSERT_NEAR(parabolaAt(f, parabolaRoot(f)), 0, 1e-14 * scaleOf(f))
        << "parabola " << f.f0 << " " << f.f1 << " " << f.saddle;
  }
}

TEST(Crossing, RootIsNearerEndWithoutChangeOfSign) {
  Random random(42);
  for (int i = 0; i < 10000; i++) {
    const Parabola<double> f = randomParabola(random);
    if ((f.f0 < 0) != (f.f1 < 0)) continue;
    ASSERT_EQ(parabolaRoot(f), std::fabs(f.f0) < std::fabs(f.f1) ? 0.0 : 1.0) << f.f0 << " " << f.f1 << " " << f.saddle;
  }
}

// --- lips ----------------------------------------------------------------------------------

struct LipCase {
  Parabola<double> f;
  double p0, p1, width, reach, epsilon;

  double p(double k) const { return p0 + k * (p1 - p0); }
  double height(double k) const { return (1 - k) * f.f0 + k * f.f1 + f.saddle * k * (1 - k); }
  // Distance of the ray from the lip; not positive inside.
  double outside(double k) const {
    return std::max({p(k) - width, height(k) - epsilon, -(reach + epsilon) - height(k)});
  }
  // Largest difference between adjacent samples.
  double step() const { return std::max(std::fabs(p1 - p0), std::fabs(f.f1 - f.f0) + std::fabs(f.saddle)) / samples; }
  bool isWithinReach(double k) const { return height(k) <= epsilon && height(k) >= -(reach + epsilon); }

  LipIntersection<double> meet() const { return intersectLip(f, p0, p1, Lip<double>{width, reach, epsilon}); }
};

LipCase randomLip(Random& random) {
  LipCase lip;
  for (double* f : {&lip.f.f0, &lip.f.f1}) *f = random.uniform(-0.3, 0.3);
  lip.f.saddle = random.chance(0.2) ? 0 : random.uniform(-1, 1);
  lip.p0 = random.uniform();
  lip.p1 = random.chance(0.1) ? lip.p0 : random.uniform();
  lip.width = (1 + random.below(16)) / 16.0;
  lip.reach = random.magnitude(1e-3, 0.2);
  lip.epsilon = random.chance(0.5) ? 0 : 1e-3 * random.uniform();
  return lip;
}

TEST(Crossing, LipIsHitWhereSamplesAreInside) {
  Random random(43);
  unsigned met = 0, missed = 0, between = 0, undecided = 0;
  for (int i = 0; i < 20000; i++) {
    const LipCase lip = randomLip(random);
    SCOPED_TRACE(testing::Message() << "lip " << i << ": f " << lip.f.f0 << " " << lip.f.f1 << " " << lip.f.saddle
                                    << ", p " << lip.p0 << " " << lip.p1 << ", width " << lip.width << ", reach "
                                    << lip.reach << ", epsilon " << lip.epsilon);
    const LipIntersection<double> meeting = lip.meet();
    const double outside = leastOf([&](double k) { return lip.outside(k); });
    if (outside <= 0) {
      ASSERT_TRUE(meeting.hit);
    } else if (outside > lip.step()) {
      ASSERT_FALSE(meeting.hit);
    } else {
      undecided++;
    }
    (meeting.hit ? met : missed)++;
    if (!meeting.hit) continue;
    ASSERT_GE(meeting.k, 0);
    ASSERT_LE(meeting.k, 1);
    ASSERT_LE(lip.p(meeting.k), lip.width + 1e-12);
    if (lip.isWithinReach(meeting.k)) continue;
    // the ray passes through the lip from above or below: compare with the first position near the side
    between++;
    const double k0 = leastOf([&](double k) { return lip.p(k) <= lip.width ? k : 1e300; });
    ASSERT_NEAR(meeting.k, k0, 1.0 / samples);
  }
  EXPECT_GT(met, 5000u);
  EXPECT_GT(missed, 5000u);
  EXPECT_GT(between, 100u);
  EXPECT_LT(undecided, 200u);
}

// Computed by hand: the ray is near the side for k from 1/2 to 1; if f is the same at both, its vertex is at 3/4.
TEST(Crossing, LipIsHitAtFirstOfEntryExitAndVertexWithinReach) {
  const double p0 = 1, p1 = 0, width = 0.5, reach = 0.1, epsilon = 0;
  auto place = [&](double entry, double vertex, double exit) {
    // the parabola through f(1/2), f(3/4), f(1) = entry, vertex, exit
    const double c = 8 * (entry + exit - 2 * vertex), slope = (exit - entry) / 0.5;
    auto at = [&](double k) { return vertex + slope * (k - 0.75) + c * (k - 0.75) * (k - 0.75); };
    const Parabola<double> f = {at(0), at(1), -c};
    EXPECT_NEAR(parabolaAt(f, 0.5), entry, 1e-12);
    EXPECT_NEAR(parabolaAt(f, 0.75), vertex, 1e-12);
    const LipIntersection<double> lip = intersectLip(f, p0, p1, Lip<double>{width, reach, epsilon});
    return lip.hit ? lip.k : -1;
  };
  EXPECT_EQ(place(-0.05, 0.2, -0.05), 0.5);
  EXPECT_EQ(place(0.2, 0.3, -0.05), 1);
  EXPECT_EQ(place(0.2, -0.05, 0.2), 0.75);
  EXPECT_EQ(place(-0.2, -0.05, -0.2), 0.75);
  EXPECT_EQ(place(0.2, -0.5, 0.2), 0.5); // none of them, but the ray passes through
  EXPECT_EQ(place(0.2, 0.05, 0.2), -1);
  EXPECT_EQ(place(-0.2, -0.15, -0.2), -1);
}

// The result of a division by zero is undefined on GPUs.
TEST(Crossing, DoesNotDivideByZero) {
  Random random(50);
  std::vector<LipCase> cases(20000);
  for (LipCase& lip : cases) {
    lip = randomLip(random);
    lip.f = randomParabola(random);
    if (random.chance(0.3)) lip.f.saddle = 0;
    if (random.chance(0.3)) lip.f.f0 = 0;
    if (random.chance(0.3)) lip.f.f1 = random.chance(0.5) ? -lip.f.saddle : lip.f.f0; // equal ends
  }
  volatile double sum = 0; // computed before the flags are tested
  std::feclearexcept(FE_ALL_EXCEPT);
  for (const LipCase& lip : cases) sum = sum + parabolaRoot(lip.f) + lip.meet().k;
  EXPECT_EQ(std::fetestexcept(FE_DIVBYZERO | FE_INVALID), 0);
  EXPECT_TRUE(std::isfinite(sum));
}

// --- patches -------------------------------------------------------------------------------

LeafPatch randomLeaf(Random& random) {
  LeafPatch leaf;
  for (int k = 0; k < 3; k++) {
    leaf.box.extent[k] = float(random.magnitude(0.05, 0.5));
    leaf.box.lower[k] = float(random.uniform(0, 1 - leaf.box.extent[k]));
  }
  // patches extend beyond their boxes
  for (float& z : leaf.z) z = leaf.box.lower[2] + float(random.uniform(-0.3, 1.3)) * leaf.box.extent[2];
  leaf.thickness = float(random.magnitude(0.01, 0.3)) * leaf.box.extent[2];
  leaf.solid = leaf.empty = false;
  return leaf;
}

TEST(Crossing, PatchIsBilinear) {
  Random random(44);
  for (int i = 0; i < 2000; i++) {
    LeafPatch leaf = randomLeaf(random);
    for (int c = 0; c < 4; c++) ASSERT_NEAR(patchZ<double>(leaf, c & 1, c >> 1), leaf.z[c], 1e-15);
    const double u = random.uniform(), v = random.uniform(), d = 1e-3;
    ASSERT_NEAR(patchZ(leaf, u, v), bilinear(leaf, u, v), 1e-14);
    // along an axis the patch is straight, so that differences are exact except for rounding
    ASSERT_NEAR(patchSlope(leaf, 0, v),
                (bilinear(leaf, u + d, v) - bilinear(leaf, u - d, v)) / (2 * d * leaf.box.extent[0]), 1e-9);
    ASSERT_NEAR(patchSlope(leaf, 1, u),
                (bilinear(leaf, u, v + d) - bilinear(leaf, u, v - d)) / (2 * d * leaf.box.extent[1]), 1e-9);
    leaf.solid = true;
    ASSERT_EQ(patchSlope(leaf, 0, v), 0);
    ASSERT_EQ(patchSlope(leaf, 1, u), 0);
  }
}

// --- crossings -----------------------------------------------------------------------------

// Segments along the line through a point of the leaf and another point, one in ten moved away.
Segment<double> randomSegment(Random& random, const NodeBox& box, double epsilon) {
  Segment<double> segment;
  auto anywhere = [&](double p[3], bool inLeaf) {
    for (int k = 0; k < 3; k++)
      p[k] = inLeaf ? box.lower[k] + random.uniform() * box.extent[k] : random.uniform(-0.2, 1.2);
  };
  double a[3], b[3];
  anywhere(a, true); // usually a point that the segment passes through
  anywhere(b, random.chance(0.2));
  const double before = random.chance(0.3) ? 0 : random.uniform(0, 3),
               behind = random.chance(0.3) ? 0.01 : random.uniform(0, 1);
  const bool missing = random.chance(0.1);
  for (int k = 0; k < 3; k++) {
    const double d = b[k] - a[k];
    segment.P0[k] = a[k] - before * d + (missing ? 0.5 : 0);
    segment.P1[k] = a[k] + behind * d + (missing ? 0.5 : 0);
    segment.epsilon[k] = epsilon * random.uniform();
  }
  if (random.chance(0.1)) std::swap(segment.P0, segment.P1);
  if (random.chance(0.1)) segment.P1[random.below(3)] = segment.P0[random.below(3)];
  if (random.chance(0.1)) {
    const int k = int(random.below(3)); // along a plane
    segment.P1[k] = segment.P0[k];
  }
  segment.t0 = 0;
  segment.t1 = 1;
  segment.w0 = segment.w1 = 1;
  segment.startClipped = random.chance(0.5);
  segment.endClipped = random.chance(0.5);
  segment.valid = true;
  return segment;
}

double at(const Segment<double>& segment, int k, double s) { return (1 - s) * segment.P0[k] + s * segment.P1[k]; }

// Distance of the line from the nearest face of the widened box, negative outside. face: this face, 2 k + (1 if upper).
// second: the distance from the next one.
double inside(const Segment<double>& segment, const NodeBox& box, double s, int* face = nullptr,
              double* second = nullptr) {
  double slack[6];
  for (int k = 0; k < 3; k++) {
    const double p = at(segment, k, s);
    slack[2 * k] = p - (double(box.lower[k]) - segment.epsilon[k]);
    slack[2 * k + 1] = double(upperOf(box, k)) + segment.epsilon[k] - p;
  }
  const int nearest = int(std::min_element(slack, slack + 6) - slack);
  const double least = slack[nearest];
  if (face) *face = nearest;
  if (second) {
    slack[nearest] = 1e300;
    *second = *std::min_element(slack, slack + 6);
  }
  return least;
}

double endBetween(const Segment<double>& segment, const NodeBox& box, double in, double out) {
  for (int i = 0; i < 60; i++) {
    const double middle = 0.5 * (in + out);
    (inside(segment, box, middle) >= 0 ? in : out) = middle;
  }
  return in;
}

struct Ends {
  double s0, s1;
  bool startsInside, endsInside;
};

// False if the segment misses the box, or nearly so. The minimum of the distances to the six planes has a single
// maximum along a line, which a ternary search finds.
bool findEnds(const Segment<double>& segment, const NodeBox& box, Ends& ends) {
  double a = 0, b = 1;
  for (int i = 0; i < 60; i++) {
    const double third = (b - a) / 3;
    if (inside(segment, box, a + third) < inside(segment, box, b - third)) a += third;
    else b -= third;
  }
  const double in = 0.5 * (a + b);
  if (inside(segment, box, in) < 1e-6) return false;
  ends.startsInside = inside(segment, box, 0) > 0;
  ends.endsInside = inside(segment, box, 1) > 0;
  ends.s0 = ends.startsInside ? 0 : endBetween(segment, box, in, 0);
  ends.s1 = ends.endsInside ? 1 : endBetween(segment, box, in, 1);
  return true;
}

// By the face, unless it is a side of the column; otherwise by f. False if two faces or the patch are too close to
// decide.
bool sideAt(const Segment<double>& segment, const LeafPatch& leaf, double s, bool insideBox, double f, uint32_t& side) {
  int face;
  double second;
  inside(segment, leaf.box, s, &face, &second);
  const bool throughZ = !insideBox && face >= 4;
  if (!insideBox && second < 1e-9) return false;
  if (!throughZ && std::fabs(f) < 1e-12) return false;
  side = throughZ ? (face == 5 ? sideAbove : sideBelow) : f >= 0 ? sideAbove : sideBelow;
  return true;
}

TEST(Crossing, EntryExitHeightsAndSidesMatchLineInBox) {
  Random random(45);
  unsigned crossings = 0, sides[2][3] = {}, against[2] = {}, started = 0, ended = 0, changes = 0;
  for (int i = 0; i < 20000; i++) {
    const LeafPatch leaf = randomLeaf(random);
    const Segment<double> segment = randomSegment(random, leaf.box, random.chance(0.5) ? 0 : 0.01);
    Ends ends;
    if (!findEnds(segment, leaf.box, ends)) continue;
    crossings++;
    SCOPED_TRACE(testing::Message() << "segment " << i);
    const Crossing<double> x = crossPatch(segment, leaf);
    ASSERT_NEAR(x.s0, ends.s0, 1e-9);
    ASSERT_NEAR(x.s1, ends.s1, 1e-9);
    auto position = [&](int axis, double s) {
      return clamped((at(segment, axis, s) - leaf.box.lower[axis]) / leaf.box.extent[axis]);
    };
    auto height = [&](double s) { return at(segment, 2, s) - bilinear(leaf, position(0, s), position(1, s)); };
    ASSERT_NEAR(x.u0, position(0, ends.s0), 1e-7);
    ASSERT_NEAR(x.v0, position(1, ends.s0), 1e-7);
    ASSERT_NEAR(x.u1, position(0, ends.s1), 1e-7);
    ASSERT_NEAR(x.v1, position(1, ends.s1), 1e-7);
    const double f0 = height(ends.s0), f1 = height(ends.s1);
    ASSERT_NEAR(x.f.f0, f0, 1e-7);
    ASSERT_NEAR(x.f.f1, f1, 1e-7);

    ASSERT_EQ(x.event.started, segment.startClipped && ends.startsInside);
    ASSERT_EQ(x.event.ended, segment.endClipped && ends.endsInside);
    started += x.event.started;
    ended += x.event.ended;
    // A segment that starts inside starts at the block's own box. It entered the leaf before, through an unknown face.
    uint32_t side;
    if ((!ends.startsInside || x.event.started) && sideAt(segment, leaf, ends.s0, ends.startsInside, f0, side)) {
      ASSERT_EQ(x.event.enter, side);
      sides[0][side]++;
      against[0] += (side == sideAbove) != (f0 >= 0);
    }
    if ((!ends.endsInside || x.event.ended) && sideAt(segment, leaf, ends.s1, ends.endsInside, f1, side)) {
      ASSERT_EQ(x.event.leave, side);
      sides[1][side]++;
      against[1] += (side == sideAbove) != (f1 >= 0);
    }
    if (std::min(std::fabs(f0), std::fabs(f1)) > 1e-6) { ASSERT_EQ(x.event.changes, (f0 >= 0) != (f1 >= 0)); }
    changes += x.event.changes;
    ASSERT_FALSE(x.event.solid);
    ASSERT_FALSE(x.event.empty);
  }
  EXPECT_GT(crossings, 10000u);
  for (const auto& end : sides)
    for (uint32_t side : {sideBelow, sideAbove}) EXPECT_GT(end[side], 2000u);
  for (unsigned count : {started, ended, changes}) EXPECT_GT(count, 500u);
  for (unsigned count : against) EXPECT_GT(count, 50u);
}

// Without epsilon, which clamps positions to the sides, f is the parabola.
TEST(Crossing, HeightOverPatchIsParabola) {
  Random random(46);
  unsigned crossings = 0;
  for (int i = 0; i < 2000; i++) {
    const LeafPatch leaf = randomLeaf(random);
    const Segment<double> segment = randomSegment(random, leaf.box, 0);
    Ends ends;
    if (!findEnds(segment, leaf.box, ends)) continue;
    crossings++;
    const Crossing<double> x = crossPatch(segment, leaf);
    for (int step = 0; step <= 10; step++) {
      const double k = 0.1 * step, s = x.s0 + k * (x.s1 - x.s0);
      const double u = (at(segment, 0, s) - leaf.box.lower[0]) / leaf.box.extent[0],
                   v = (at(segment, 1, s) - leaf.box.lower[1]) / leaf.box.extent[1];
      ASSERT_NEAR(parabolaAt(x.f, k), at(segment, 2, s) - bilinear(leaf, u, v), 1e-7) << "segment " << i << ", k " << k;
    }
  }
  EXPECT_GT(crossings, 1000u);
}

// "near" must be set if the ray comes within half a thickness and epsilon, or if f changes its sign. It must not be set
// otherwise if the distance is larger by a quarter of the saddle. "nearEntry" is exact.
TEST(Crossing, NearIsSetForRaysWithinReachOfPatch) {
  Random random(47);
  unsigned near = 0, notNear = 0, onlyBySaddle = 0;
  for (int i = 0; i < 20000; i++) {
    const LeafPatch leaf = randomLeaf(random);
    const Segment<double> segment = randomSegment(random, leaf.box, random.chance(0.5) ? 0 : 0.01);
    Ends ends;
    if (!findEnds(segment, leaf.box, ends)) continue;
    SCOPED_TRACE(testing::Message() << "segment " << i);
    const Crossing<double> x = crossPatch(segment, leaf);
    const double reach = 0.5 * double(leaf.thickness) + segment.epsilon[2];
    auto height = [&](double k) { return std::fabs((1 - k) * x.f.f0 + k * x.f.f1 + x.f.saddle * k * (1 - k)); };
    const double least = leastOf(height), slack = 1e-7;
    if (least <= reach - slack || (x.f.f0 < 0) != (x.f.f1 < 0)) {
      ASSERT_TRUE(x.event.near);
      const double atEnds = std::min(height(0), height(1));
      onlyBySaddle += atEnds > reach && !x.event.changes;
    }
    if (least > reach + 0.25 * std::fabs(x.f.saddle) + slack) { ASSERT_EQ(x.event.near, x.event.changes); }
    if (std::fabs(height(0) - reach) > slack) { ASSERT_EQ(x.event.nearEntry, height(0) <= reach); }
    (x.event.near ? near : notNear)++;
  }
  EXPECT_GT(near, 2000u);
  EXPECT_GT(notNear, 2000u);
  EXPECT_GT(onlyBySaddle, 20u);
}

TEST(Crossing, OnlyBorderLeavesHaveLipsAndOnlyAtBorderSides) {
  Random random(48);
  unsigned met[4] = {}, inner = 0;
  const uint32_t last = 3;
  for (int i = 0; i < 6000; i++) {
    const LeafPatch leaf = randomLeaf(random);
    const Segment<double> segment = randomSegment(random, leaf.box, 0);
    Ends ends;
    if (!findEnds(segment, leaf.box, ends)) continue;
    const Crossing<double> x = crossPatch(segment, leaf);
    const double width = (1 + random.below(16)) / 16.0, reach = 0.5 * double(leaf.thickness);
    // by the position of the ray relative to the side: x lower, x upper, y lower, y upper
    LipCase lips[4];
    double outside[4];
    for (int side = 0; side < 4; side++) {
      const double a = side < 2 ? x.u0 : x.v0, b = side < 2 ? x.u1 : x.v1;
      lips[side] = {x.f, side & 1 ? 1 - a : a, side & 1 ? 1 - b : b, width, reach, 0};
      outside[side] = leastOf([&](double k) { return lips[side].outside(k); });
    }
    for (uint32_t cell = 0; cell < 16; cell++) {
      const uint32_t cx = cell % 4, cy = cell / 4;
      const bool border[4] = {cx == 0, cx == last, cy == 0, cy == last};
      const LipIntersection<double> meeting = intersectLipsOfLeaf(x, cx, cy, last, Lip<double>{width, reach, 0.0});
      SCOPED_TRACE(testing::Message() << "segment " << i << ", leaf " << cx << " " << cy);
      bool isMet = false, isUndecided = false;
      for (int side = 0; side < 4 && !isMet; side++) {
        if (!border[side]) continue;
        const LipCase& lip = lips[side];
        isUndecided |= outside[side] > 0 && outside[side] <= lip.step();
        if (outside[side] > 0) continue;
        isMet = true;
        met[side]++;
        if (isUndecided) continue;
        // the first side that is hit determines the position
        const double k = meeting.k;
        ASSERT_LE(lip.p(k), width + 1e-6);
        ASSERT_NEAR(k, lip.meet().k, 1e-6);
      }
      if (!isUndecided) { ASSERT_EQ(meeting.hit, isMet); }
      inner += !border[0] && !border[1] && !border[2] && !border[3];
    }
  }
  for (unsigned count : met) EXPECT_GT(count, 500u);
  EXPECT_GT(inner, 5000u);
}

}} // namespace programs::test
