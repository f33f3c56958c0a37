// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Hard cases: blocks of difficult shapes, sizes and positions. */

#include "hard_cases/hard_case.h"
#include "support/reference_check.h"

namespace programs::test { namespace {

const Placement atOrigin = {1, {0, 0, 0}};

class HardBlocks : public HardCase {
protected:
  // minimum share of rays that hit at the reference's t
  double exact = 0.75;

  void trace(const std::vector<Shape>& shapes, const std::vector<Placement>& placements, unsigned raysPerKind) {
    Random random(33);
    ReferenceCheck check(device, compression());
    for (unsigned height : {0, 1, 2, 3, 4, 5})
      for (const Placement& at : placements)
        for (Shape shape : shapes) {
          check.trace(random, randomSheet(random, shape, height, at), allRays, raysPerKind);
          if (HasFatalFailure()) return;
        }
    check.conclude(exact);
  }
  void trace(Shape shape) { trace({shape}, {atOrigin, atOrigin}, 12); }

  // Sheets without a usable frame.
  void expectGridsHits(Random& random, const std::vector<Sheet>& sheets) {
    ReferenceCheck check(device, compression());
    for (const Sheet& sheet : sheets) check.trace(random, sheet, allRays, 50);
    // cVERT has no frames and supports any vertices.
    EXPECT_EQ(check.sheetsOfGrid, compression() == RTC_COMPRESSION_CVERT ? 0 : sheets.size());
  }
};
INSTANTIATE_TEST_SUITE_P(HardCases, HardBlocks, testing::ValuesIn(tracers()), tracerName);

TEST_P(HardBlocks, Needles) {
  property("blocks a thousand times as long as wide are traced as the reference traces them");
  trace(Shape::Needle);
}

TEST_P(HardBlocks, Flat) {
  property("plane blocks are traced as the reference traces them");
  trace(Shape::Flat);
}

TEST_P(HardBlocks, Folded) {
  property("blocks that fold over are traced as the reference traces them");
  trace(Shape::Folded);
}

TEST_P(HardBlocks, Saddles) {
  property("saddles are traced as the reference traces them");
  trace(Shape::Saddle);
}

TEST_P(HardBlocks, Trapezoids) {
  property(
      "blocks in projective frames are traced as the reference traces them: the ray's parameter and normals follow W");
  trace(Shape::Trapezoid);
}

TEST_P(HardBlocks, Spikes) {
  property("blocks with spikes half as high as they are wide are traced as the reference traces them");
  trace(Shape::Spikes);
}

TEST_P(HardBlocks, Jumps) {
  property("blocks whose displacement jumps are traced as the reference traces them");
  trace(Shape::Jumps);
}

TEST_P(HardBlocks, Vertical) {
  property("blocks displaced until they stand on their frame are traced as the reference traces them");
  trace(Shape::Vertical);
}

TEST_P(HardBlocks, Noise) {
  property("blocks of noise are traced as the reference traces them");
  trace(Shape::Noise);
}

TEST_P(HardBlocks, CollapsedQuads) {
  property(
      "quads of zero area (lines, triangles, points) harm no other: blocks are traced as the reference traces them");
  trace(Shape::CollapsedQuads);
}

TEST_P(HardBlocks, CollapsedSides) {
  property("blocks with a side of length zero are traced as the reference traces them");
  trace(Shape::CollapsedSide);
}

TEST_P(HardBlocks, LinesAndPoints) {
  property("blocks of zero area, all vertices on a line or in a point, are left to GRID and have its hits");
  Random random(34);
  std::vector<Sheet> sheets;
  for (const Vec& line : {Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 0}}) {
    sheets.push_back(randomSheet(random, Shape::Flat, 3, atOrigin));
    for (Vec& p : sheets.back().vertices)
      for (int k = 0; k < 3; k++) p[k] *= line[k];
  }
  expectGridsHits(random, sheets);
}

TEST_P(HardBlocks, NeedlesBeyondAllFrames) {
  property(
      "needles 2^-16 to 2^-20 as wide as long, whose leaves would be wider than their quads, are left to GRID and have "
      "its hits");
  Random random(36);
  std::vector<Sheet> sheets;
  for (float width : {0x1p-16f, 0x1p-18f, 0x1p-20f})
    for (int axis : {0, 1}) {
      sheets.push_back(randomSheet(random, Shape::Flat, 3, atOrigin));
      for (std::vector<Vec>* points : {&sheets.back().vertices, &sheets.back().cage.positions})
        for (Vec& p : *points) p[axis] *= width;
    }
  expectGridsHits(random, sheets);
}

TEST_P(HardBlocks, Outliers) {
  property(
      "blocks with a vertex 1e6 to 1e12 block widths away, whose leaves would be wider than their quads, are left to "
      "GRID and have its hits");
  Random random(35);
  std::vector<Sheet> sheets;
  for (double distance : {1e6, 1e9, 1e12})
    for (int axis = 0; axis < 3; axis++) {
      sheets.push_back(randomSheet(random, Shape::Waves, 4, atOrigin));
      sheets.back().vertices[random.below(17 * 17)][axis] = float(distance);
    }
  expectGridsHits(random, sheets);
}

TEST_P(HardBlocks, ScalesFrom1em6To1e6) {
  property("blocks of every shape, 1e-6 to 1e6 wide, are traced as the reference traces them");
  std::vector<Placement> placements;
  for (double scale : {1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6}) placements.push_back({scale, {0, 0, 0}});
  trace(allShapes, placements, 1);
}

TEST_P(HardBlocks, FarFromTheOrigin) {
  property("blocks of every shape far from the origin, a thousandth of a unit wide at 1, a unit wide at (148376, 1234, "
           "-223423), are traced as the reference traces them");
  exact = 0.6;
  trace(allShapes, {{1e-3, {0.5, -0.25, 1}}, {1, {148376, 1234, -223423}}, {1e3, {1e6, 1e6, -1e6}}}, 2);
}

}} // namespace programs::test
