// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Fuzz target: arbitrary bytes as a cVERT block. In valid blocks, the traversal's decoder stays within the block and
// the padding after it. block_decoding.cpp tests the scalar decoder.

#include "block_seeds.h"
#include "kernels/cbvh/exact/motion_decoder.h"

#include <memory>

namespace programs::test {
namespace {

using namespace embree::cbvh;

using embree::isa::cbvh::MotionDecoder;
using embree::isa::cbvh::VertDecoder;

void decode(const VertHeader* block) {
  const VertDecoder decoder(block);
  auto entry = std::make_unique<VertBlockEntry>();
  decoder.decode(*entry);
  auto vertices = std::make_unique<CellVertices>();
  for (uint32_t lane = 0; lane < 16; lane++)
    if (entry->lanes >> lane & 1) decoder.vertices(*entry, lane, *vertices);
  if (!isMoving(block->info)) return;
  const MotionDecoder moving(block);
  auto segmentEntry = std::make_unique<VertSegmentEntry>();
  auto group = std::make_unique<SegmentVertices>();
  for (uint32_t segment = 0; segment + 1 < motionOf(block).numSteps; segment++) {
    segmentEntry->key = {block, segment, 0};
    moving.decode(segment, *segmentEntry);
    for (uint32_t lane = 0; lane < 16; lane++)
      if (segmentEntry->lanes >> lane & 1) moving.vertices(*segmentEntry, lane, *group);
  }
}

} // namespace

void writeSeeds(const std::string& folder) { writeBlockSeeds(folder); }

} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ::programs::test;
  if (size == 0) return 0;
  const ExactMemory bytes(data, size, 16);
  if (validateVert(bytes.get(), size)) return 0;
  std::vector<uint8_t> longer(data, data + size);
  longer.resize(size + vertReadPadding);
  const ExactMemory block(longer.data(), longer.size(), 16);
  decode((const VertHeader*)block.get());
  return 0;
}
