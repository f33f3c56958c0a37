// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

// cVERT blocks as seeds, static and moving.

#include "fuzz_input.h"
#include "kernels/cvert/decoder/validate.h"
#include "kernels/cvert/encoder/motion_encoder.h"

#include <memory>
#include <vector>

namespace programs::test {

using namespace cvert;

// isRigid: later steps have no residuals of their own, and therefore the fewest bytes
inline void writeMovingSeed(const std::string& path, uint32_t quads, bool isRawBlock, bool isRigid) {
  static const auto encoder = std::make_unique<MotionEncoder>();
  std::vector<uint8_t> bytes(MotionEncoder::maxBytes(3));
  encoder->begin({packRegion(quads, quads, 0, 0), packPatchQuads(quads, quads)}, 0, 1, 3, bytes.data());
  for (int step = 0; step < 3; step++) {
    for (uint32_t v = 0; v < (quads + 1) * (quads + 1); v++) {
      const uint32_t x = v % (quads + 1), y = v / (quads + 1);
      encoder->vertices()[v][0] = float(16 * x);
      encoder->vertices()[v][1] = float(16 * y) + float(isRigid ? step : step * (x * y % 5));
      encoder->vertices()[v][2] = isRawBlock && v == 0 && step == 1 ? NAN : float(x * y % 5);
    }
    encoder->addStep();
  }
  MotionStatistics statistics;
  const size_t size = encoder->finish(statistics);
  REQUIRE(!validateVert(bytes.data(), size));
  REQUIRE(validateVert(bytes.data(), size - 4));
  writeSeed(path, std::string((const char*)bytes.data(), size));
}

inline void writeBlockSeeds(const std::string& folder) {
  auto encoder = std::make_unique<VertEncoder>();
  std::vector<uint8_t> bytes(VertEncoder::maxBytes);
  int n = 0;
  for (uint32_t quads : {1u, 4u, 7u, 16u})
    for (bool isRawBlock : {false, true})
      for (bool isRigid : {false, true})
        writeMovingSeed(folder + "/moving" + std::to_string(n++), quads, isRawBlock, isRigid);
  for (uint32_t quads : {1u, 4u, 7u, 16u})
    for (bool isRawBlock : {false, true})
      for (bool hasEdges : {false, true}) {
        for (uint32_t v = 0; v < (quads + 1) * (quads + 1); v++) {
          const uint32_t x = v % (quads + 1), y = v / (quads + 1);
          encoder->vertices[v][0] = float(16 * x);
          encoder->vertices[v][1] = float(16 * y);
          encoder->vertices[v][2] = isRawBlock && v == 0 ? NAN : float(x * y % 5);
        }
        VertPlacement at(packRegion(quads, quads, 0, 0), packPatchQuads(quads, quads));
        if (hasEdges) at = VertPlacement(at.region, at.patchQuads, packEdges(1, quads, quads, quads, 1, 5));
        VertStatistics statistics;
        const size_t size = encoder->encode(at, bytes.data(), statistics);
        REQUIRE(!validateVert(bytes.data(), size));
        REQUIRE(validateVert(bytes.data(), size - 4));
        writeSeed(folder + "/" + std::to_string(n++), std::string((const char*)bytes.data(), size));
      }
}

} // namespace programs::test
