// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/edge_rates.h"
#include "surface/mapped_texture.h"

#include <algorithm>
#include <cmath>

namespace programs {

float EdgeRates::level(const Copy& copy, unsigned face, float u, float v) const {
  const float level = interpolate(&copy.levels[firstIndex[face]], sizes[face], FacePoint{face, u, v});
  return std::clamp(level, 0.0f, float(finestLevel));
}

void setLevels(const Cage& cage, EdgeRates& rates) {
  rates.firstIndex.clear();
  rates.sizes.assign(cage.faceSizes.begin(), cage.faceSizes.end());
  size_t first = 0;
  for (unsigned n : rates.sizes) {
    rates.firstIndex.push_back(first);
    first += n;
  }
  rates.quads = 0;
  std::vector<float> highest(cage.positions.size());
  for (EdgeRates::Copy& copy : rates.copies) {
    std::fill(highest.begin(), highest.end(), 1.0f);
    for (size_t face = 0; face < rates.sizes.size(); face++)
      for (unsigned i = 0, n = rates.sizes[face]; i < n; i++)
        for (unsigned corner : {i, (i + 1) % n}) {
          float& h = highest[cage.faceIndices[rates.firstIndex[face] + corner]];
          h = std::max(h, copy.rates[rates.firstIndex[face] + i]);
        }
    copy.levels.resize(copy.rates.size());
    for (size_t i = 0; i < copy.levels.size(); i++) copy.levels[i] = std::log2(highest[cage.faceIndices[i]]);
    rates.quads += countQuads(cage, copy.rates);
  }
}

size_t countQuads(const Cage& cage, const std::vector<float>& rates) {
  size_t quads = 0, first = 0;
  for (unsigned n : cage.faceSizes) {
    const auto rate = [&](unsigned i) { return size_t(std::ceil(rates[first + i % n])); };
    const auto half = [&](unsigned i) { return std::max<size_t>((rate(i) + 1) / 2, 1); };
    if (n == 4) quads += std::max(rate(0), rate(2)) * std::max(rate(1), rate(3));
    else
      for (unsigned i = 0; i < n; i++) quads += half(i) * half(i + n - 1);
    first += n;
  }
  return quads;
}

} // namespace programs
