// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Fuzz target of the codec: arbitrary bytes as a cVERT block. Validation reads no other bytes, and neither does
// decoding of a valid block at every time step, including boxes and numbers of quads.

#include "block_seeds.h"
#include "kernels/cvert/decoder/decoded_block.h"

namespace programs::test {
namespace {

void decode(const VertHeader* block, uint32_t step) {
  const auto decoded = std::make_unique<DecodedBlock>(block, step);
  float lower[3], upper[3];
  decoded->bounds(lower, upper);
  const VertLayout layout = vertLayout(block->region, block->info);
  const StepView view = viewOfStep(block, layout, step);
  REQUIRE(view.isLater == (step > 0) && (isRaw(view.info) || decoded->end <= (const uint8_t*)block + vertBytes(block)));
  if (isRaw(view.info)) {
    for (uint32_t v = 0; v < (decoded->quadsX + 1) * (decoded->quadsY + 1); v++)
      for (int k = 0; k < 3; k++) {
        const float x = rawCoordinate(view, v, k);
        REQUIRE(std::memcmp(&x, &decoded->vertices[v][k], sizeof(x)) == 0);
      }
    if (step == 0)
      for (uint32_t g = 0; g < layout.groups; g++) decoded->groupBox(g, lower, upper);
    return;
  }
  if (step > 0 && !hasMargins(view.info)) return;
  for (uint32_t g = 0; g < layout.groups; g++) decoded->groupBox(g, view.info, view.data + view.margins, lower, upper);
}

} // namespace

void writeSeeds(const std::string& folder) { writeBlockSeeds(folder); }

} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ::programs::test;
  if (size == 0) return 0;
  const ExactMemory bytes(data, size, 16);
  if (validateVert(bytes.get(), size)) return 0;
  const VertHeader* const block = (const VertHeader*)bytes.get();
  REQUIRE(vertBytes(block) <= size);
  for (uint32_t step = 0; step < (isMoving(block->info) ? motionOf(block).numSteps : 1); step++) decode(block, step);
  if (hasPrimIDs(block->info))
    for (uint32_t y = 0; y < vertQuadsY(block->region); y++)
      for (uint32_t x = 0; x < vertQuadsX(block->region); x++) {
        primitiveOfQuad(block, x, y, false);
        primitiveOfQuad(block, x, y, true);
      }
  return 0;
}
