// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Random numbers with a fixed seed. Failures within the lifetime of a generator print the seed. */

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>

namespace programs::test {

class Random {
public:
  explicit Random(uint32_t seed) : engine(seed), trace(__FILE__, __LINE__, "seed " + std::to_string(seed)) {}

  uint32_t bits() { return engine(); }
  uint32_t below(uint32_t n) { return uint32_t((uint64_t(engine()) * n) >> 32); }
  bool chance(double p) { return uniform() < p; }

  // Uniform in [0,1) with 53 bits. Independent of the standard library, unlike its distributions.
  double uniform() { return double(((uint64_t(engine()) << 32 | engine()) >> 11)) * 0x1p-53; }
  double uniform(double a, double b) { return a + (b - a) * uniform(); }

  double normal() { return std::sqrt(-2 * std::log(1 - uniform())) * std::cos(2 * M_PI * uniform()); }

  // Between a and b, with a uniform logarithm.
  double magnitude(double a, double b) { return a * std::pow(b / a, uniform()); }

private:
  std::mt19937 engine;
  testing::ScopedTrace trace;
};

} // namespace programs::test
