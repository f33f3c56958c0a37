// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Steps in parameters across the borders of patches, compared with the surface. */

#include "support/random_cages.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

/* A plane of unit squares, each with a random first corner. */
TEST(PatchWalk, LinesStayStraightForAnyOrientationOfFaces) {
  Random random(6);
  constexpr unsigned n = 8;
  Cage cage = sheet(n);
  for (unsigned face = 0; face < n * n; face++)
    std::rotate(cage.faceIndices.begin() + 4 * face, cage.faceIndices.begin() + 4 * face + random.below(4),
                cage.faceIndices.begin() + 4 * face + 4);
  const Model model = modelOf(cage);
  const TrueSurface surface(model);
  for (int i = 0; i < 1000; i++) {
    const PatchPoint p{(2 + random.below(4)) * n + 2 + random.below(4), 0, random.uniform(), random.uniform()};
    const TruePoint from = surface.evaluate(p);
    const double u = random.uniform(-1, 1), v = random.uniform(-1, 1);
    const TruePoint to = surface.evaluate(surface.patches().advance(p, u, v));
    EXPECT_NEAR(length(from.position + u * from.du + v * from.dv - to.position), 0, 1e-9);
  }
}

TEST(PatchWalk, CrossedBordersContinueOnTheSurface) {
  Random random(7);
  Cage holed = moved(sheet(4), random, 0.3);
  holed.holes = {5, 10};
  for (const Cage& cage : {prism(3), prism(6), trapezohedron(4), holed}) {
    const Model model = modelOf(cage);
    const TrueSurface surface(model);
    for (int i = 0; i < 1000; i++) {
      PatchPoint p = randomPoint(cage, surface, random);
      const unsigned edge = random.below(4);
      double& across = edge % 2 ? p.u : p.v;
      double& along = edge % 2 ? p.v : p.u;
      const double border = edge == 1 || edge == 2 ? 1 : 0, outward = border == 1 ? 1 : -1;
      along = 0.1 + 0.8 * along;
      constexpr double least = 1e-9;
      const double side = random.uniform(-0.1, 0.1);
      across = border;
      const PatchPoint q =
          surface.patches().advance(p, edge % 2 ? outward * least : side, edge % 2 ? side : outward * least);
      along += side;
      EXPECT_LT(length(surface.evaluate(p).position - surface.evaluate(q).position), 1e-7)
          << "face " << p.face << " edge " << edge << " to face " << q.face;

      /* The distance beyond the border is the same on the other side. */
      along -= side;
      const double depth = random.uniform(0.01, 0.2);
      const PatchPoint far =
          surface.patches().advance(p, edge % 2 ? outward * depth : 0, edge % 2 ? 0 : outward * depth);
      if (far.face == p.face && far.subPatch == p.subPatch) {
        ASSERT_FALSE(cage.holes.empty()) << "a closed cage has no boundary";
        continue;
      }
      const unsigned here = cage.faceSizes[p.face], there = cage.faceSizes[far.face];
      const double scale = here == 4 && there != 4 ? 2 : here != 4 && there == 4 ? 0.5 : 1;
      const double depths[4] = {far.u, far.v, 1 - far.u, 1 - far.v};
      EXPECT_TRUE(std::any_of(depths, depths + 4, [&](double d) { return std::abs(d - scale * depth) < 1e-9; }));
    }
  }
}

}} // namespace programs::test
