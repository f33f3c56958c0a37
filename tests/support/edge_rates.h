// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Random edge rates, similar to those that renderers choose by distance, and cages for them. */

#include "support/random.h"
#include "support/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

namespace programs::test {

typedef std::function<float(Random&)> DrawRate;

// One rate per index of the faces, equal on both sides of each edge.
inline std::vector<float> drawRates(const Cage& cage, Random& random, const DrawRate& draw) {
  std::map<std::pair<unsigned, unsigned>, float> rateOf;
  std::vector<float> rates;
  size_t begin = 0;
  for (unsigned n : cage.faces) {
    for (unsigned i = 0; i < n; i++) {
      const unsigned a = cage.indices[begin + i], b = cage.indices[begin + (i + 1) % n];
      const auto edge = std::minmax(a, b);
      if (!rateOf.count(edge)) rateOf[edge] = draw(random);
      rates.push_back(rateOf[edge]);
    }
    begin += n;
  }
  return rates;
}

// clang-format off
const struct { const char* name; DrawRate draw; } rateSets[] = {
  {"1 to 64",      [](Random& r) { return float(1 + r.below(64)); }},
  {"1 or 64",      [](Random& r) { return r.chance(0.5) ? 1.0f : 64.0f; }},
  {"5 or 13",      [](Random& r) { return r.chance(0.5) ? 5.0f : 13.0f; }},
  {"13",           [](Random&)   { return 13.0f; }},
  {"fractions",    [](Random& r) { return float(r.uniform(0.5, 40)); }},
  {"powers of 2",  [](Random& r) { return float(1u << r.below(7)); }},
};
// clang-format on

inline Cage creasedCube() {
  Cage cage = cubeCage();
  cage.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  cage.creaseWeights = {INFINITY, 2.5f, 0.7f, INFINITY};
  return cage;
}

const struct {
  const char* name;
  Cage cage;
} closedCages[] = {
    {"cube", cubeCage()},        {"triangles", prismCage(3)},         {"pentagons", prismCage(5)},
    {"heptagons", prismCage(7)}, {"valence 9", trapezohedronCage(9)}, {"creases", creasedCube()},
};

inline std::string nameOf(const testing::TestParamInfo<RTCCompression>& info) { return kindName(info.param); }

} // namespace programs::test
