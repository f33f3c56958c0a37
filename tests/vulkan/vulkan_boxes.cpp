// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Bottom levels for ray queries are the same if their boxes are. Requires no device. */

#include "kernels/vulkan/host/boxes_key.h"

#include <gtest/gtest.h>

#include <unordered_set>

namespace embree::vulkan { namespace {

typedef std::vector<VkAabbPositionsKHR> Boxes;

TEST(VulkanBoxes, EqualBoxesAreTheSameLevel) {
  const Boxes boxes = {{0, 0, 0, 1, 1, 1}, {1, 0, 0, 2, 1, 1}};
  EXPECT_TRUE(BoxesKey(boxes) == BoxesKey(boxes));
  const BoxesKey key(boxes), copy = key;
  EXPECT_TRUE(key == copy);
}

TEST(VulkanBoxes, OtherBoxesOfTheSameHashAreAnotherLevel) {
  const BoxesKey a(Boxes{{-0x1.09cp-1f, -0x1.154p-1f, -0x1.d8p-1f, 1, 1, 1}}),
      b(Boxes{{-0x1.b98p-1f, -0x1.f7p-1f, -0x1.fp-2f, 1, 1, 0x1.e78p+0f}});
  ASSERT_EQ(a.hash(), b.hash()) << "the test needs other boxes, whose hashes collide";
  EXPECT_FALSE(a == b);
  EXPECT_EQ((std::unordered_set<BoxesKey, HashOfKey>{a, b}.size()), 2u);
}

TEST(VulkanBoxes, MoreBoxesAreAnotherLevel) {
  const Boxes one = {{0, 0, 0, 1, 1, 1}}, two = {one[0], one[0]};
  EXPECT_FALSE(BoxesKey(one) == BoxesKey(two));
}

}} // namespace embree::vulkan
