// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Fuzz target of the codec: arbitrary bytes as a mesh block. Validation reads no other bytes. Decoding of a valid block
// at every time step, including boxes and numbers, reads at most vertReadPadding bytes after it. Indices of decoded
// triangles are vertices of their group, and vertices of their block.

#include "mesh_seeds.h"
#include "kernels/cvert/decoder/decoded_mesh.h"

namespace programs::test {

void writeSeeds(const std::string& folder) {
  forEachMeshSeed([&](const std::string& name, const void* block, size_t bytes) {
    writeSeed(folder + "/" + name, std::string((const char*)block, bytes));
  });
}

namespace {

void decode(const MeshHeader* block, uint32_t step) {
  const auto mesh = std::make_unique<DecodedMesh>(block, step);
  REQUIRE(mesh->numTriangles <= maxMeshTriangles && mesh->numVertices <= maxMeshVertices);
  for (uint32_t t = 0; t < mesh->numTriangles; t++)
    for (uint32_t v : mesh->triangles[t]) REQUIRE(v < mesh->numVertices);
  const MeshView view(block);
  float lower[3], upper[3];
  for (uint32_t g = 0; g < view.groups; g++)
    if (step == 0) {
      view.groupBox(g, lower, upper);
      const DecodedMeshGroup group(view, g);
      for (uint32_t t = 0; t < group.numTriangles; t++)
        for (int c = 0; c < 3; c++) REQUIRE(group.indices[c][t] < group.numVertices);
    } else MeshStepView(view, step).groupBox(g, lower, upper);
}

} // namespace
} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ::programs::test;
  if (size == 0) return 0;
  if (const ExactMemory bytes(data, size, 16); validateMesh(bytes.get(), size)) return 0;
  std::vector<uint8_t> padded(data, data + size);
  padded.resize(size + vertReadPadding);
  const ExactMemory bytes(padded.data(), padded.size(), 16);
  const MeshHeader* const block = (const MeshHeader*)bytes.get();
  REQUIRE(block->bytes <= size);
  for (uint32_t step = 0; step < (isMovingMesh(block) ? motionOfMesh(block).numSteps : 1); step++) decode(block, step);
  return 0;
}
