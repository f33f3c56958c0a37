// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Fuzz target: any bytes for a block of cVERT. Validation reads none but those, and what it passes decodes: scalar code and
// the traversal's decoder stay within the block and what they may read behind it.

#include "fuzz_support.h"

#include "kernels/cbvh/vert/motion_decoder.h"
#include "kernels/cvert/encoder/motion_encoder.h"
#include "kernels/cvert/decoder/validate.h"
#include "kernels/cvert/decoder/decoded_block.h"

#include <memory>

namespace cbvh::test {
namespace {

using namespace embree::cbvh;

using namespace cvert;
using embree::isa::cbvh::MotionDecoder;
using embree::isa::cbvh::VertDecoder;

void decode(const VertHeader* block)
{
  const VertDecoder decoder(block);
  auto boxes = std::make_unique<VertBoxes>();
  decoder.decode(*boxes);
  auto quads = std::make_unique<QuadCorners>();
  for (uint32_t lane = 0; lane < 16; lane++)
    if (boxes->lanes >> lane & 1) decoder.quads(*boxes, lane, *quads);
  if (!isMoving(block->boxForm)) return;
  const MotionDecoder moving(block);
  auto shared = std::make_unique<SegmentBoxes>();
  auto group = std::make_unique<SegmentVertices>();
  for (uint32_t segment = 0; segment + 1 < motionOf(block).numSteps; segment++) {
    shared->key = {block, segment, 0};
    moving.decode(segment, *shared);
    for (uint32_t lane = 0; lane < 16; lane++)
      if (shared->lanes >> lane & 1) moving.vertices(*shared, lane, *group);
  }
}

// isRigid: later steps have no residuals of their own, and so the fewest bytes
void writeMovingSeed(const std::string& path, uint32_t quads, bool isRawBlock, bool isRigid)
{
  static const auto encoder = std::make_unique<MotionEncoder>();
  std::vector<uint8_t> bytes(MotionEncoder::maxBytes(3));
  encoder->begin({vertRegion(quads, quads, 0, 0), vertPatch(quads, quads)}, 0, 1, 3, bytes.data());
  for (int step = 0; step < 3; step++) {
    for (uint32_t v = 0; v < (quads + 1)*(quads + 1); v++) {
      const uint32_t x = v % (quads + 1), y = v/(quads + 1);
      encoder->vertices()[v][0] = float(16*x);
      encoder->vertices()[v][1] = float(16*y) + float(isRigid ? step : step*(x*y % 5));
      encoder->vertices()[v][2] = isRawBlock && v == 0 && step == 1 ? NAN : float(x*y % 5);
    }
    encoder->addStep();
  }
  MotionStatistics statistics;
  const size_t size = encoder->finish(statistics);
  REQUIRE(!validateVert(bytes.data(), size));
  REQUIRE(validateVert(bytes.data(), size - 4));
  FILE* file = std::fopen(path.c_str(), "wb");
  REQUIRE(file && std::fwrite(bytes.data(), size, 1, file) == 1);
  std::fclose(file);
}

void writeSeeds(const std::string& folder)
{
  auto encoder = std::make_unique<VertEncoder>();
  std::vector<uint8_t> bytes(VertEncoder::maxBytes);
  int n = 0;
  for (uint32_t quads : {1u, 4u, 7u, 16u})
    for (bool isRawBlock : {false, true})
      for (bool isRigid : {false, true}) writeMovingSeed(folder + "/moving" + std::to_string(n++), quads, isRawBlock, isRigid);
  for (uint32_t quads : {1u, 4u, 7u, 16u})
    for (bool isRawBlock : {false, true})
      for (bool hasEdges : {false, true}) {
        for (uint32_t v = 0; v < (quads + 1)*(quads + 1); v++) {
          const uint32_t x = v % (quads + 1), y = v/(quads + 1);
          encoder->vertices[v][0] = float(16*x);
          encoder->vertices[v][1] = float(16*y);
          encoder->vertices[v][2] = isRawBlock && v == 0 ? NAN : float(x*y % 5);
        }
        VertPlacement at(vertRegion(quads, quads, 0, 0), vertPatch(quads, quads));
        if (hasEdges) at = VertPlacement(at.region, at.patchQuads, vertEdges(1, quads, quads, quads, 1, 5));
        VertStatistics statistics;
        const size_t size = encoder->encode(at, bytes.data(), statistics);
        REQUIRE(!validateVert(bytes.data(), size));
        REQUIRE(validateVert(bytes.data(), size - 4));
        FILE* file = std::fopen((folder + "/" + std::to_string(n++)).c_str(), "wb");
        REQUIRE(file && std::fwrite(bytes.data(), size, 1, file) == 1);
        std::fclose(file);
      }
}

} // namespace
} // namespace cbvh::test

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) { return ::cbvh::test::readArguments(*argc, *argv, ::cbvh::test::writeSeeds); }

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
  using namespace ::cbvh::test;
  if (size == 0) return 0;
  const ExactMemory bytes(data, size, 16);
  if (validateVert(bytes.get(), size)) return 0;
  const VertHeader* const exact = (const VertHeader*)bytes.get();
  REQUIRE(vertBytes(exact) <= size);
  for (uint32_t step = 0; step < (isMoving(exact->boxForm) ? motionOf(exact).numSteps : 1); step++)
    std::make_unique<DecodedBlock>(exact, step); // reads nothing after the block
  std::vector<uint8_t> longer(data, data + size);
  longer.resize(size + readBehindVert);
  const ExactMemory block(longer.data(), longer.size(), 16);
  decode((const VertHeader*)block.get());
  return 0;
}
