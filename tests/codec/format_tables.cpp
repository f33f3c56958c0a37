// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The tables of kernels/cbvh/paper/README.md, code by code, through the decoders, and its epsilon. Encoder and
 * decoders share the tables: if these changed, all other tests would pass, but existing blocks would have another
 * meaning. */

#include "kernels/cbvh/paper/leaf/format.h"
#include "kernels/cbvh/paper/local_ray.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace programs::test { namespace {

using namespace embree::cbvh;

TEST(FormatTables, PlanesOfNodesMatchPage) {
  const float outer[4] = {0, 6, 16, 36}, inner[8] = {116, 125, 130, 136, 144, 160, 192, 256}; // 1/256
  for (uint32_t pair = 0; pair < 32; pair++)
    for (int axis = 0; axis < 2; axis++) {
      SCOPED_TRACE(testing::Message() << "pair " << pair << ", axis " << axis);
      const float o = outer[pair & 3] / 256, i = inner[pair >> 2] / 256;
      const int next = 1 << axis; // the child next to child 0
      const uint32_t lower = pair << (10 * axis), upper = pair << (10 * axis + 5);
      EXPECT_EQ(decodeChild(lower, 0, rootBox()).lower[axis], o);
      EXPECT_EQ(decodeChild(lower, next, rootBox()).lower[axis], 1 - i);
      EXPECT_EQ(upperOf(decodeChild(upper, next, rootBox()), axis), 1 - o);
      EXPECT_EQ(upperOf(decodeChild(upper, 0, rootBox()), axis), i);
    }
}

TEST(FormatTables, IntervalsOfNodesMatchPage) {
  const float intervals[8][2] = {{0, 32}, {7, 26}, {2, 20}, {16, 32}, {11, 23}, {7, 19}, {14, 28}, {0, 15}}; // 1/32
  for (uint32_t code = 0; code < 8; code++)
    for (int child = 0; child < 4; child++) {
      const NodeBox box = decodeChild(code << (20 + 3 * child), child, rootBox());
      EXPECT_EQ(box.lower[2], intervals[code][0] / 32) << "code " << code;
      EXPECT_EQ(upperOf(box, 2), intervals[code][1] / 32) << "code " << code;
    }
}

TEST(FormatTables, PlanesOfLatticesMatchPage) {
  for (uint32_t code = 0; code < 32; code++)
    for (int axis = 0; axis < 2; axis++) {
      SCOPED_TRACE(testing::Message() << "code " << code << ", axis " << axis);
      const float outer = float(4 * code + code * code / 4) / 1024, middle = float(33 + 2 * code) / 128;
      EXPECT_EQ(latticePlane(code << (15 * axis), axis, 0, rootBox()), outer);
      EXPECT_EQ(latticePlane(code << (15 * axis + 5), axis, 2, rootBox()), 1 - outer);
      EXPECT_EQ(latticePlane(code << (15 * axis + 10), axis, 1, rootBox()), middle);
    }
}

TEST(FormatTables, HeightsAndThicknessOfLatticesMatchPage) {
  const float bins[4] = {1, 2, 5, 16}, bin = 1.5f / 128; // of a box 1 high
  for (uint32_t code = 0; code < 4; code++)
    for (uint32_t height = 0; height < 128; height++) {
      const LeafPatch leaf = decodeLeaf(code << 30, Heights{height, 0}, 0, rootBox()); // vertex 0
      ASSERT_EQ(leaf.z[0], -0.25f + (float(height) + 0.5f) * bin) << "height " << height;
      ASSERT_EQ(leaf.thickness, bins[code] * bin) << "code " << code;
    }
}

TEST(FormatTables, HeightsAndThicknessOfSeparateLeavesMatchPage) {
  const float bins[8] = {1, 1.5f, 2, 3, 4, 6, 8, 12}, bin = 2.0f / 32; // of a box 1 high
  for (uint32_t code = 0; code < 8; code++)
    for (uint32_t height = 0; height < 32; height++) {
      const LeafPatch leaf = decodeLeaf(0, Heights{height, 1u << 31 | code << 28}, 0, rootBox()); // corner (0,0)
      ASSERT_EQ(leaf.z[0], -0.5f + (float(height) + 0.5f) * bin) << "height " << height;
      ASSERT_EQ(leaf.thickness, bins[code] * bin) << "code " << code;
      ASSERT_FALSE(leaf.solid || leaf.empty);
    }
  EXPECT_TRUE(decodeLeaf(0, Heights{0x7FFF, 1u << 31}, 0, rootBox()).solid);
  EXPECT_TRUE(decodeLeaf(0, Heights{0x7FFE, 1u << 31}, 0, rootBox()).empty);
}

TEST(FormatTables, EpsilonOfRaysMatchesPage) {
  Random random(17);
  const double ulp = 0x1p-23;
  for (int i = 0; i < 1000; i++) {
    BlockHeader block = {};
    double stretch[4] = {};
    for (auto& column : block.columns)
      for (int k = 0; k < 4; k++) {
        column[k] = float(random.normal());
        stretch[k] += std::fabs(column[k]);
      }
    const double distance = random.chance(0.2) ? 0 : random.magnitude(1e-3, 1e3);
    const double reach = distance + 0.75 / std::min({stretch[0], stretch[1], stretch[2]});
    for (int k = 0; k < 3; k++) {
      const double expected = 4 * ulp * reach * (stretch[k] + stretch[3]) + 8 * ulp;
      ASSERT_NEAR(rayEpsilon(block, distance, k), expected, 1e-12 * expected)
          << "axis " << k << ", distance " << distance;
    }
  }
}

}} // namespace programs::test
