// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/vec.h"

#include <gtest/gtest.h>

namespace programs { namespace {

/* Powers of two change no digit, also where the square of the length is out of range. */
TEST(Vec, LengthAndDirectionAreAccurateAtEveryScale) {
  const Vec3f v{0.75f, -1.625f, 1.3f};
  for (int exponent = -120; exponent <= 125; exponent++) {
    const float scale = std::ldexp(1.0f, exponent);
    EXPECT_NEAR(length(v * scale) / scale, length(v), 2e-7f * length(v)) << exponent;
    EXPECT_LT(length(normalize(v * scale) - normalize(v)), 2e-7f) << exponent;
    EXPECT_TRUE(hasDirection(v * scale)) << exponent;
  }
}

TEST(Vec, LengthOfZeroAndOfInfinityIsTheSame) {
  EXPECT_EQ(length(Vec3f{}), 0.0f);
  EXPECT_EQ(length(Vec3f{0, INFINITY, 0}), INFINITY);
  EXPECT_TRUE(std::isnan(length(Vec3f{0, NAN, 0})));
  EXPECT_FALSE(hasDirection(Vec3f{}));
}

}} // namespace programs
