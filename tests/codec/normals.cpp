// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Geometric normals of hits in the frame of a block, and the rule for flipping them. */

#include "kernels/cbvh/paper/frame_map.h"
#include "kernels/cbvh/paper/normal.h"
#include "support/random.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

using namespace embree::cbvh;

// A frame with varying W, around the origin.
Block randomFrame(Random& random) {
  Block block = {};
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 4; k++) block.columns[i][k] = float((i == k ? 0.5 : 0) + 0.1 * random.uniform(-1, 1));
  return block;
}

// Orthogonal to two tangents of the surface, and on the side of increasing z.
TEST(Normals, MatchSurfaceInWorldSpace) {
  Random random(17);
  for (int i = 0; i < 2000; i++) {
    const Block block = randomFrame(random);
    const InverseFrame inverse(frameMap(&block));
    const double x = random.uniform(), y = random.uniform(), z = random.uniform(), sx = 2 * random.normal(),
                 sy = 2 * random.normal(), step = 1e-6;
    const Vector<double> n = worldNormal<double>(block, {{x, y, z}}, sx, sy);
    const Double3 normal = {n.x[0], n.x[1], n.x[2]}, o = inverse({x, y, z});
    auto cosine = [&](const Double3& to) {
      const Double3 d = to - o;
      return dot(normal, d) / (length(normal) * length(d));
    };
    ASSERT_NEAR(cosine(inverse({x + step, y, z + step * sx})), 0, 1e-4) << "frame " << i;
    ASSERT_NEAR(cosine(inverse({x, y + step, z + step * sy})), 0, 1e-4) << "frame " << i;
    ASSERT_GT(cosine(inverse({x, y, z + step})), 0) << "frame " << i;
  }
}

// From above (along < 0), normals face the ray; from below they face away.
TEST(Normals, FlipIfFacingAwayByLessThan30Degrees) {
  for (double direction2 : {1.0, 9.0})
    for (double normal2 : {1.0, 0.25}) {
      const double length = std::sqrt(direction2 * normal2);
      for (int degrees = -90; degrees <= 90; degrees++) { // angle of the ray over the surface, along its normal
        if (std::abs(degrees) == 30) continue;            // both results are valid
        const double along = length * std::sin(degrees * M_PI / 180);
        SCOPED_TRACE(degrees);
        EXPECT_EQ(isMirrored(along, normal2, direction2, sideAbove), degrees > 0 && degrees < 30);
        EXPECT_EQ(isMirrored(along, normal2, direction2, sideBelow), degrees < 0 && degrees > -30);
        EXPECT_FALSE(isMirrored(along, normal2, direction2, sideUnknown));
      }
    }
}

}} // namespace programs::test
