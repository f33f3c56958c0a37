// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Encodes with the codec as the including file compiles it, so that a test can compare two builds. Define HERE before:
 * a namespace that no other file uses. */

#include "cvert/encoder/lattice.h"
#include "cvert/encoder/motion_encoder.h"

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

namespace programs::test::HERE {

// Returns the bytes of a block of width x height quads. steps: x, y and z of the vertices of each time step, row by
// row, which are snapped to multiples of 2^exponent.
inline std::vector<uint8_t> encode(const std::vector<std::vector<float>>& steps, uint32_t width, uint32_t height,
                                   int exponent) {
  const cvert::WorldLattice lattice(exponent);
  const cvert::VertPlacement place(cvert::packRegion(width, height, 0, 0), cvert::packPatchQuads(width, height));
  const auto fill = [&](const std::vector<float>& from, float(*to)[3]) {
    for (size_t i = 0; i < from.size(); i++) to[i / 3][i % 3] = lattice.snap(from[i]);
  };
  std::vector<uint64_t> words(cvert::MotionEncoder::maxBytes(steps.size()) / 8 + 1);
  uint8_t* const out = (uint8_t*)words.data();
  size_t size;
  if (steps.size() == 1) {
    const auto encoder = std::make_unique<cvert::VertEncoder>();
    fill(steps[0], encoder->vertices);
    cvert::VertStatistics statistics;
    size = encoder->encode(place, out, statistics);
  } else {
    const auto encoder = std::make_unique<cvert::MotionEncoder>();
    encoder->begin(place, 0, 1, uint32_t(steps.size()), out);
    for (const auto& step : steps) {
      fill(step, encoder->vertices());
      encoder->addStep();
    }
    cvert::MotionStatistics statistics;
    size = encoder->finish(statistics);
  }
  return {out, out + size};
}

} // namespace programs::test::HERE
