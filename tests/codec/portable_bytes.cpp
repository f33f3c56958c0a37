// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The encoder writes the same bytes in plain C++ and with vector instructions. */

#define HERE vectors
#include "encode_here.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace programs::test {

std::vector<uint8_t> encodePortably(const std::vector<std::vector<float>>& steps, uint32_t width, uint32_t height,
                                    int exponent);

namespace {

TEST(PortableBytes, PlainCodeMatchesVectorCode) {
  Random random(5);
  size_t numRaw = 0, total = 0;
  for (int i = 0; i < 3000; i++) {
    SCOPED_TRACE(i);
    const uint32_t width = 1 + random.below(16), height = 1 + random.below(16),
                   numSteps = random.chance(0.3) ? 2 + random.below(3) : 1;
    const double roughness = std::exp2(random.uniform(-12, 2)),
                 far = random.chance(0.3) ? std::exp2(random.uniform(0, 60)) : 0;
    const int exponent = random.chance(0.2) ? cvert::losslessExponent : int(random.below(24)) - 20;
    double slopes[3][2], bend[3];
    for (int k = 0; k < 3; k++) {
      for (double& slope : slopes[k]) slope = random.uniform(-1, 1);
      bend[k] = random.uniform(-0.1, 0.1);
    }
    std::vector<std::vector<float>> steps(numSteps);
    for (uint32_t s = 0; s < numSteps; s++)
      for (uint32_t v = 0; v < (width + 1) * (height + 1); v++)
        for (int k = 0; k < 3; k++) {
          const double x = v % (width + 1), y = v / (width + 1),
                       z = slopes[k][0] * x + slopes[k][1] * y + bend[k] * x * (y + s) + roughness * random.normal();
          steps[s].push_back(random.chance(0.0002) ? NAN : float(far * (k + 1) + z));
        }
    const std::vector<uint8_t> bytes = vectors::encode(steps, width, height, exponent),
                               portable = encodePortably(steps, width, height, exponent);
    ASSERT_EQ(bytes, portable);
    numRaw += !bytes.empty() && cvert::isRaw(((const cvert::VertHeader*)bytes.data())->info);
    total++;
  }
  EXPECT_GT(numRaw, 10u);
  EXPECT_LT(numRaw, total / 2);
}

} // namespace
} // namespace programs::test
