// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The map of a block keeps vertices in the box and straight lines straight, for all sizes and positions. The encoder
 * falls back to an affine map if a projective one is ill-conditioned. */

#include "kernels/cbvh/paper/frame_fit.h"
#include "kernels/cbvh/paper/node.h"
#include "support/random.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace programs::test { namespace {

using namespace embree::cbvh;

struct Sheet {
  std::vector<float> vertices;
  float corners[4][3];

  const float (*data() const)[3] { return (const float(*)[3])vertices.data(); }
  size_t count() const { return vertices.size() / 3; }
  bool fit(Frame& frame) const {
    std::vector<Double3> scratch(count());
    return fitFrame(corners, data(), count(), scratch.data(), frame);
  }
};

struct Placement {
  double scale;
  double position[3];
};

// width x width vertices between four corners, with random heights along the normal; rotated, scaled and moved.
Sheet makeSheet(Random& random, const double corners[4][3], int width, double amplitude, const Placement& at) {
  double axis[3][3];
  for (int k = 0; k < 3; k++) axis[0][k] = random.normal();
  for (int k = 0; k < 3; k++) axis[1][k] = random.normal();
  auto normalize = [](double* a) {
    const double l = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    for (int k = 0; k < 3; k++) a[k] /= l;
  };
  normalize(axis[0]);
  const double d = axis[0][0] * axis[1][0] + axis[0][1] * axis[1][1] + axis[0][2] * axis[1][2];
  for (int k = 0; k < 3; k++) axis[1][k] -= d * axis[0][k];
  normalize(axis[1]);
  for (int k = 0; k < 3; k++)
    axis[2][k] = axis[0][(k + 1) % 3] * axis[1][(k + 2) % 3] - axis[0][(k + 2) % 3] * axis[1][(k + 1) % 3];

  Sheet sheet;
  auto place = [&](const double p[3], float out[3]) {
    for (int k = 0; k < 3; k++)
      out[k] = float(at.position[k] + at.scale * (p[0] * axis[0][k] + p[1] * axis[1][k] + p[2] * axis[2][k]));
  };
  for (int c = 0; c < 4; c++) place(corners[c], sheet.corners[c]);
  for (int y = 0; y < width; y++)
    for (int x = 0; x < width; x++) {
      const double u = double(x) / (width - 1), v = double(y) / (width - 1);
      double p[3];
      for (int k = 0; k < 3; k++)
        p[k] =
            (1 - v) * ((1 - u) * corners[0][k] + u * corners[1][k]) + v * ((1 - u) * corners[2][k] + u * corners[3][k]);
      p[2] += amplitude * random.normal();
      float q[3];
      place(p, q);
      sheet.vertices.insert(sheet.vertices.end(), q, q + 3);
    }
  return sheet;
}

// The map of a frame in double precision, as specified in kernels/cbvh/paper/README.md.
void homogeneous(const Frame& frame, const double p[3], double h[4]) {
  h[0] = h[1] = h[2] = 0.5;
  h[3] = 1;
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 4; k++) h[k] += double(frame.columns[i][k]) * (p[i] - double(frame.center[i]));
}

// Decoded planes, including the root's, keep the distance containmentSlack from the geometry (node.h).
void expectInside(const Sheet& sheet, const Frame& frame) {
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 4; k++) ASSERT_TRUE(std::isfinite(frame.columns[i][k]));
  for (size_t i = 0; i < sheet.count(); i++) {
    double l[3];
    frame.transform(sheet.data()[i], l);
    for (int k = 0; k < 3; k++) {
      ASSERT_GE(l[k], containmentSlack) << "vertex " << i << ", axis " << k;
      ASSERT_LE(l[k], 1 - containmentSlack) << "vertex " << i << ", axis " << k;
    }
  }
}

// The map has an inverse with W > 0 at all corners.
void expectBounded(const Frame& frame) {
  auto row = [&](int k, double d) {
    return embree::cbvh::LinearForm{{frame.columns[0][k], frame.columns[1][k], frame.columns[2][k]}, d};
  };
  const FrameMap map = {row(0, 0.5), row(1, 0.5), row(2, 0.5), row(3, 1), frame.projective};
  for (int i = 0; i < 8; i++) {
    Double3 p;
    ASSERT_TRUE(unproject(map, i & 1, (i >> 1) & 1, i >> 2, p));
    const double w = map.W(p);
    EXPECT_GT(w, 0.9 / (2 * maxWRatio));
    EXPECT_LT(w, 1.1 * (2 * maxWRatio));
  }
}

void expectProperties(const Sheet& sheet, Frame& frame) {
  ASSERT_TRUE(sheet.fit(frame));
  expectInside(sheet, frame);
  expectBounded(frame);
}

const double square[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
const double trapezoid[4][3] = {{0, 0, 0}, {1, 0, 0}, {0.2, 0.7, 0}, {0.8, 0.7, 0}};

std::vector<Placement> placements() {
  std::vector<Placement> list;
  for (double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) list.push_back({scale, {0, 0, 0}});
  for (double scale : {1e-3, 0.1, 1.0, 1e6}) list.push_back({scale, {148376, 1234, -223423}});
  list.push_back({1e-6, {1, -1, 1}});              // less than ten ulps wide
  list.push_back({1e-6, {148376, 1234, -223423}}); // less than one ulp wide
  list.push_back({1e-3, {0, 0, 1e6}});
  return list;
}

TEST(Frame, VerticesAreInsideBoxBySlackAtAnySizeAndPosition) {
  Random random(21);
  for (const Placement& at : placements())
    for (int i = 0; i < 300; i++) {
      double corners[4][3];
      for (int c = 0; c < 4; c++)
        for (int k = 0; k < 3; k++)
          corners[c][k] = i % 3 == 0 ? random.normal() : square[c][k] + (i % 3) * 0.15 * random.normal();
      const double amplitude = i % 5 == 0 ? 0 : random.magnitude(1e-4, 3);
      Frame frame;
      SCOPED_TRACE(testing::Message() << "scale " << at.scale << " at " << at.position[0] << ", sheet " << i);
      const Sheet sheet = makeSheet(random, corners, 2 + i % 6, amplitude, at);
      expectProperties(sheet, frame);
      if (HasFatalFailure()) return;
    }
}

TEST(Frame, VerticesTouchFacesOfBox) {
  Random random(22);
  for (int i = 0; i < 200; i++) {
    Frame frame;
    const Sheet sheet = makeSheet(random, i & 1 ? square : trapezoid, 5, 0.1, {1, {0, 0, 0}});
    ASSERT_TRUE(sheet.fit(frame));
    double lower[3] = {1, 1, 1}, upper[3] = {0, 0, 0};
    for (size_t v = 0; v < sheet.count(); v++) {
      double l[3];
      frame.transform(sheet.data()[v], l);
      for (int k = 0; k < 3; k++) {
        lower[k] = std::min(lower[k], l[k]);
        upper[k] = std::max(upper[k], l[k]);
      }
    }
    for (int k = 0; k < 3; k++) {
      // the margin, doubled if rounding requires it, and the rounding of the map to floats
      EXPECT_LT(lower[k], 4 * frameMargin);
      EXPECT_GT(upper[k], 1 - 4 * frameMargin);
    }
  }
}

// The segment P0 to P1 of a line o + t d between t0 and t1 maps back to its parameter by t = t0 + (t1-t0) s w0/(w1
// (1-s) + s w0), exactly except for the rounding of double, amplified by at most the extent of the map.
TEST(Frame, StraightLinesStayStraightAndParameterMapIsExact) {
  Random random(23);
  unsigned projective = 0, curved = 0;
  for (int i = 0; i < 2000; i++) {
    double corners[4][3];
    for (int c = 0; c < 4; c++)
      for (int k = 0; k < 3; k++) corners[c][k] = trapezoid[c][k] + 0.1 * random.normal();
    Frame frame;
    const Sheet sheet = makeSheet(random, corners, 3, 0.05, {1, {0, 0, 0}});
    ASSERT_TRUE(sheet.fit(frame));
    projective += frame.projective;

    const float* a = sheet.data()[random.below(9)];
    const float* b = sheet.data()[random.below(9)];
    if (a == b) continue;
    double h0[4], h1[4], o[3] = {a[0], a[1], a[2]}, e[3] = {b[0], b[1], b[2]};
    homogeneous(frame, o, h0);
    homogeneous(frame, e, h1);
    curved += std::fabs(h0[3] / h1[3] - 1) > 0.1;
    const double t0 = 3, t1 = 7;
    for (double s : {0.0, 0.1, 0.35, 0.5, 0.9, 1.0}) {
      const double tau = s * h0[3] / (h1[3] * (1 - s) + s * h0[3]), t = t0 + tau * (t1 - t0);
      double p[3], h[4];
      for (int k = 0; k < 3; k++) p[k] = o[k] + (t - t0) / (t1 - t0) * (e[k] - o[k]);
      homogeneous(frame, p, h);
      for (int k = 0; k < 3; k++) {
        const double p0 = h0[k] / h0[3], p1 = h1[k] / h1[3];
        ASSERT_NEAR(h[k] / h[3], p0 + s * (p1 - p0), 1e-13) << "line " << i << ", s " << s;
      }
    }
  }
  EXPECT_GT(projective, 1000u);
  EXPECT_GT(curved, 500u) << "too few maps have a varying W";
}

// Within the margin and the rounding of the map's entries to floats.
TEST(Frame, CornersOfTrapezoidMapToUnitSquare) {
  Random random(24);
  for (int i = 0; i < 200; i++) {
    Frame frame;
    const Sheet sheet = makeSheet(random, trapezoid, 2, 0, {random.magnitude(1e-6, 1e6), {0, 0, 0}});
    ASSERT_TRUE(sheet.fit(frame));
    ASSERT_TRUE(frame.projective);
    for (int c = 0; c < 4; c++) {
      double l[3];
      frame.transform(sheet.data()[c], l);
      EXPECT_NEAR(l[0], c & 1, 4 * frameMargin);
      EXPECT_NEAR(l[1], c >> 1, 4 * frameMargin);
    }
  }
}

// x is along u, y along v, z along the normal of the quad's winding.
TEST(Frame, IsRightHanded) {
  Random random(25);
  for (int i = 0; i < 200; i++) {
    double corners[4][3];
    for (int c = 0; c < 4; c++)
      for (int k = 0; k < 3; k++) corners[c][k] = square[c][k] + 0.05 * random.normal();
    Frame frame;
    const Sheet sheet = makeSheet(random, corners, 3, 0.1, {1, {0, 0, 0}});
    ASSERT_TRUE(sheet.fit(frame));
    const float(*m)[4] = frame.columns;
    const double det = double(m[0][0]) * (double(m[1][1]) * m[2][2] - double(m[1][2]) * m[2][1]) -
                       double(m[1][0]) * (double(m[0][1]) * m[2][2] - double(m[0][2]) * m[2][1]) +
                       double(m[2][0]) * (double(m[0][1]) * m[1][2] - double(m[0][2]) * m[1][1]);
    EXPECT_GT(det, 0);
  }
}

struct Bad {
  const char* name;
  double corners[4][3];
};
const Bad bad[] = {
    {"folded", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
    {"dented", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 0}}},
    {"collapsed edge", {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 1, 0}}},
    {"triangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 0}}},
    {"zero area", {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}}},
    {"line", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}},
    {"point", {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}},
    {"W varies", {{0, 0, 0}, {1, 0, 0}, {0.45, 1, 0}, {0.55, 1, 0}}},
};

TEST(Frame, FallsBackToAffineIfProjectiveIsIllConditioned) {
  Random random(26);
  for (const Bad& b : bad)
    for (double amplitude : {0.0, 0.3})
      for (const Placement& at : placements()) {
        SCOPED_TRACE(testing::Message() << b.name << ", amplitude " << amplitude << ", scale " << at.scale << " at "
                                        << at.position[0]);
        Frame frame;
        const Sheet sheet = makeSheet(random, b.corners, 5, amplitude, at);
        expectProperties(sheet, frame);
        if (HasFatalFailure()) return;
        if (at.position[0] == 0 && at.position[2] == 0) { // at other positions rounding may unfold the quad
          EXPECT_FALSE(frame.projective);
          for (int i = 0; i < 3; i++) EXPECT_EQ(frame.columns[i][3], 0.0f);
        }
      }
}

// No axis may be so steep that a box is thinner than the resolution of its position.
TEST(Frame, NeedlesAndFlatSheetsHaveInvertibleMaps) {
  Random random(27);
  const double aspect[] = {1e-2, 1e-4, 1e-6, 1e-9};
  for (double a : aspect)
    for (const Placement& at : placements()) {
      double needle[4][3];
      for (int c = 0; c < 4; c++) {
        needle[c][0] = c & 1;
        needle[c][1] = a * (c >> 1);
        needle[c][2] = 0;
      }
      for (const Sheet& sheet : {makeSheet(random, needle, 5, 0, at), makeSheet(random, needle, 5, a, at),
                                 makeSheet(random, square, 5, a, at)}) {
        SCOPED_TRACE(testing::Message() << "aspect " << a << ", scale " << at.scale << " at " << at.position[0]);
        Frame frame;
        expectProperties(sheet, frame);
        if (HasFatalFailure()) return;
      }
    }
}

// Needles thinner than about 2^-14 of their length should not be compressed. Flat sheets are always compressed.
TEST(Frame, NeedlesAreDegenerateButFlatSheetsAreNot) {
  Random random(29);
  for (double scale : {1e-3, 1.0, 1e3})
    for (int along : {0, 1})
      for (double a : {0x1p-10, 0x1p-12, 0x1p-16, 0x1p-18}) {
        double needle[4][3];
        for (int c = 0; c < 4; c++) {
          needle[c][along] = along ? c >> 1 : c & 1;
          needle[c][1 - along] = a * (along ? c & 1 : c >> 1);
          needle[c][2] = 0;
        }
        Frame frame;
        SCOPED_TRACE(testing::Message() << "aspect " << a << ", scale " << scale);
        ASSERT_TRUE(makeSheet(random, needle, 5, 0, {scale, {0, 0, 0}}).fit(frame));
        EXPECT_EQ(frame.degenerate, a < 0x1p-14);
        ASSERT_TRUE(makeSheet(random, square, 5, a, {scale, {0, 0, 0}}).fit(frame));
        EXPECT_FALSE(frame.degenerate);
      }
}

TEST(Frame, CoincidentVerticesGetBoxAroundPoint) {
  for (float x : {0.0f, 1e-6f, 1.0f, 148376.0f, 1e6f}) {
    Sheet sheet;
    for (int i = 0; i < 9; i++)
      for (int k = 0; k < 3; k++) sheet.vertices.push_back(k == 1 ? -x : x);
    for (int c = 0; c < 4; c++) std::copy_n(sheet.vertices.data(), 3, sheet.corners[c]);
    Frame frame;
    expectProperties(sheet, frame);
    double l[3];
    frame.transform(sheet.data()[0], l);
    for (int k = 0; k < 3; k++) EXPECT_NEAR(l[k], 0.5, 1e-3) << "at " << x;
  }
}

// Up to the largest float. Differences exceed the range of float, and maps are denormal.
TEST(Frame, SheetsWithLargestCoordinatesHaveFrames) {
  Random random(28);
  for (double largest : {double(maxCoordinate), 1e30, double(std::numeric_limits<float>::max())})
    for (int i = 0; i < 100; i++) {
      SCOPED_TRACE(testing::Message() << "coordinates up to " << largest << ", sheet " << i);
      // before scaling, no vertex is farther than 1 from the center
      const double side = 0.5;
      double corners[4][3];
      for (int c = 0; c < 4; c++)
        for (int k = 0; k < 3; k++)
          corners[c][k] = k == 2 ? 0 : side * ((c >> k) & 1 ? 1 : -1) * (i % 2 ? random.uniform(0.7, 1) : 1);
      Sheet sheet = makeSheet(random, corners, 2 + i % 4, 0, {largest, {0, 0, 0}});
      Frame frame;
      expectProperties(sheet, frame);
      if (HasFatalFailure()) return;
    }
  // vertices at the corners of the range of floats
  const float huge = std::numeric_limits<float>::max();
  Sheet sheet;
  for (int c = 0; c < 4; c++)
    for (int k = 0; k < 3; k++) sheet.corners[c][k] = k == 2 ? 0 : ((c >> k) & 1 ? huge : -huge);
  sheet.vertices.assign(&sheet.corners[0][0], &sheet.corners[0][0] + 12);
  Frame frame;
  expectProperties(sheet, frame);
}

}} // namespace programs::test
