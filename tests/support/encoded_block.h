// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A single block without a scene: the encoder's result for given vertices. */

#include "kernels/cbvh/paper/block_encoder.h"

#include <algorithm>
#include <vector>

namespace programs::test {

class EncodedBlock {
public:
  embree::cbvh::BlockStatistics statistics;

  // vertices: xyz of (2^height+1)^2 vertices, row by row; corners: the frame is aligned to (0,0), (1,0), (0,1),
  // (1,1); x, y: position in the patch, in blocks
  EncodedBlock(embree::cbvh::Kind kind, uint32_t height, const std::vector<float>& vertices, const float corners[4][3],
               uint32_t x = 0, uint32_t y = 0)
    : memory(embree::cbvh::blockLayout(uint32_t(kind), height).bytes / sizeof(Unit) + 1) {
    std::vector<Unit> scratch(embree::cbvh::BlockEncoder::scratchBytes(height) / sizeof(Unit) + 1);
    embree::cbvh::BlockEncoder encoder(kind, height, (const float(*)[3])vertices.data(), scratch.data());
    hasFrame = encoder.fit(corners);
    if (hasFrame) encoder.encode((embree::cbvh::Block*)memory.data(), x, y, statistics);
  }

  // False if no vertex is finite. There is no block then.
  explicit operator bool() const { return hasFrame; }

  embree::cbvh::Block* get() { return (embree::cbvh::Block*)memory.data(); }
  const embree::cbvh::Block* get() const { return (const embree::cbvh::Block*)memory.data(); }

  embree::cbvh::Frame frame() const {
    embree::cbvh::Frame frame = {};
    std::copy_n(get()->center, 3, frame.center);
    std::copy_n(&get()->columns[0][0], 12, &frame.columns[0][0]);
    return frame;
  }

private:
  struct alignas(16) Unit {
    char bytes[16];
  };

  std::vector<Unit> memory;
  bool hasFrame;
};

} // namespace programs::test
