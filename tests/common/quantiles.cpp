// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/quantiles.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

TEST(Quantiles, AreNearestRanks) {
  std::vector<float> values;
  for (int i = 100; i > 0; i--) values.push_back(float(i));
  EXPECT_EQ(quantile(values, 0.5), 50.0);
  EXPECT_EQ(quantile(values, 0.99), 99.0);
  EXPECT_EQ(quantile(values, 1.0), 100.0);
  std::vector<float> none;
  EXPECT_EQ(quantile(none, 0.5), 0.0);
}

TEST(Quantiles, MedianAndInterquartileRange) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({4, 1}), 2.5);
  EXPECT_EQ(median({9, 1, 5}), 5);
  EXPECT_EQ(interquartileRange({7}), 0);
  EXPECT_EQ(interquartileRange({1, 2, 3, 4, 100}), 2) << "one outlier has no effect";
}

}} // namespace programs::test
