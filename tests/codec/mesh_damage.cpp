// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Damaged mesh blocks, still and moving, are rejected with a reason, or decoded without reading other bytes. Each block
 * is an allocation of exactly its size, for sanitizers. */

#include "kernels/cvert/encoder/block_encoder.h"
#include "kernels/cvert/decoder/decoded_mesh.h"
#include "kernels/cvert/decoder/validate.h"
#include "kernels/cvert/decoder/validate_mesh.h"
#include "support/moving_mesh.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t seed = 815;

// Still blocks of several kinds: sheets and soups, on and off lattices.
std::vector<Words> stillBlocks(Random& random) {
  std::vector<Words> blocks;
  auto encoder = std::make_unique<MeshEncoder>();
  MeshStatistics statistics;
  for (int i = 0; i < 24; i++) {
    const uint32_t count = i < 12 ? 1 + random.below(40) : 256, groupSize = std::vector<uint32_t>{1, 16, 32}[i % 3];
    const bool soup = i % 4 == 0, lattice = i % 2 == 0;
    std::vector<MeshTriangle> mesh(count);
    for (uint32_t t = 0; t < count; t++) {
      const uint32_t x = t / 2 % 12, y = t / 24;
      const uint32_t corners[2][3][2] = {{{0, 0}, {1, 0}, {0, 1}}, {{1, 1}, {0, 1}, {1, 0}}};
      for (int c = 0; c < 3; c++) {
        const uint32_t px = x + corners[t % 2][c][0], py = y + corners[t % 2][c][1];
        const double p[3] = {px + 0.1 * std::sin(7.0 * px + 3 * py), double(py), 0.3 * px + std::sin(0.3 * px * py)};
        for (int k = 0; k < 3; k++)
          mesh[t].corners[c][k] = soup      ? float(random.normal())
                                  : lattice ? float(std::floor(64 * p[k]) / 64)
                                            : float(p[k]);
      }
      mesh[t].number = i % 5 == 0 ? random.bits() : 1000 + t;
    }
    std::vector<uint32_t> ends;
    for (uint32_t end = groupSize; ends.empty() || ends.back() < count; end += groupSize)
      ends.push_back(std::min(end, count));
    Words words(MeshEncoder::maxBytes / 4);
    uint32_t stored;
    words.resize(encoder->encode(mesh.data(), ends.data(), uint32_t(ends.size()), 0, (uint8_t*)words.data(), stored,
                                 statistics) /
                 4);
    words.shrink_to_fit();
    EXPECT_EQ(validateMesh(words.data(), 4 * words.size()).message(), "");
    blocks.push_back(words);
  }
  return blocks;
}

std::vector<Words> movingBlocks(Random& random) {
  std::vector<Words> blocks;
  auto encoder = std::make_unique<MeshMotionEncoder>();
  MeshStatistics statistics;
  for (int i = 0; i < 16; i++)
    for (const EncodedBlock& block : encode(
             *encoder,
             sheet(random, 1 + random.below(10), 2 + uint32_t(i % 3), i % 2 ? -1000 : -10, i % 4 < 2 ? turned : bent),
             i % 3 ? 16 : 32, statistics))
      blocks.push_back(block.words);
  return blocks;
}

std::vector<Words> blocksOf(Random& random, bool isMoving) {
  return isMoving ? movingBlocks(random) : stillBlocks(random);
}

TEST(MeshDamage, GridReadersRejectMeshBlocksByVersion) {
  Random random(seed);
  for (bool isMoving : {false, true})
    for (const Words& block : blocksOf(random, isMoving)) {
      const MeshHeader& header = *(const MeshHeader*)block.data();
      EXPECT_EQ(versionOfBlock(header.counts, header.info), isMoving ? movingMeshFormatVersion : meshFormatVersion);
      const Reason reason = validateVert(block.data(), 4 * block.size());
      EXPECT_EQ(reason.code, ErrorCode::UNSUPPORTED) << reason.message();
      EXPECT_NE(reason.message().find(isMoving ? "version 7" : "version 6"), std::string::npos) << reason.message();
      EXPECT_TRUE(isMeshBlock(block.data()));
    }
}

TEST(MeshDamage, MeshReadersRejectGridBlocks) {
  auto encoder = std::make_unique<VertEncoder>();
  for (int i = 0; i < 25; i++)
    for (int k = 0; k < 3; k++) encoder->vertices[i][k] = float(k == 0 ? i % 5 : k == 1 ? i / 5 : i % 3);
  alignas(16) uint8_t bytes[VertEncoder::maxBytes];
  VertStatistics statistics;
  const size_t size = encoder->encode({packRegion(4, 4, 0, 0), packPatchQuads(4, 4)}, bytes, statistics);
  const Reason reason = validateMesh(bytes, size);
  EXPECT_EQ(reason.code, ErrorCode::UNSUPPORTED);
  EXPECT_NE(reason.message().find("kind 0"), std::string::npos) << reason.message();
  EXPECT_FALSE(isMeshBlock(bytes));
}

void expectUnsupported(Words block, size_t word, uint32_t bit) {
  block[word] ^= 1u << bit;
  const Reason reason = validateMesh(block.data(), 4 * block.size());
  EXPECT_EQ(reason.code, ErrorCode::UNSUPPORTED) << "word " << word << ", bit " << bit << ": " << reason.message();
}

TEST(MeshDamage, NewerFeaturesAreUnsupported) {
  Random random(seed + 1);
  const Words still = stillBlocks(random)[20], moving = movingBlocks(random)[4];
  // kind and version
  for (uint32_t bit : {14u, 15u, 30u, 31u}) {
    expectUnsupported(still, 12, bit);
    expectUnsupported(still, 13, bit);
  }
  for (uint32_t bit = 24; bit < 32; bit++) expectUnsupported(still, 3, bit);
  for (uint32_t bit = 27; bit < 30; bit++) expectUnsupported(still, 13, bit);
  for (uint32_t bit = 0; bit < 32; bit++) expectUnsupported(still, 7, bit); // motion
  expectUnsupported(moving, 12, 15);                                        // version 6 with motion
  const MeshHeader* const header = (const MeshHeader*)moving.data();
  const size_t step = size_t((const uint32_t*)meshStepOf(header, 1) - moving.data());
  for (uint32_t bit = 24; bit < 32; bit++) expectUnsupported(moving, step + 3, bit);
  for (uint32_t bit = 30; bit < 32; bit++) expectUnsupported(moving, step + 16, bit);
  expectUnsupported(moving, step + 17, 15);
}

TEST(MeshDamage, TruncatedBlocksAreRejected) {
  Random random(seed + 2);
  for (bool isMoving : {false, true})
    for (const Words& block : blocksOf(random, isMoving))
      for (size_t bytes = 0; bytes < 4 * block.size(); bytes += bytes >= 400 ? 37 : isMoving ? 5 : 1) {
        const Words part(block.begin(), block.begin() + (bytes + 3) / 4);
        ASSERT_TRUE(validateMesh(part.data(), bytes)) << bytes << " of " << 4 * block.size() << " bytes";
      }
}

void decode(const MeshHeader* block) {
  const MeshView view(block);
  volatile float sum = 0; // reads all vertices
  float lower[3], upper[3];
  for (uint32_t g = 0; g < view.groups; g++) view.groupBox(g, lower, upper);
  for (uint32_t step = 0; step < (isMovingMesh(block) ? motionOfMesh(block).numSteps : 1); step++) {
    const auto mesh = std::make_unique<DecodedMesh>(block, step);
    for (uint32_t t = 0; t < mesh->numTriangles; t++)
      for (uint32_t v : mesh->triangles[t]) {
        ASSERT_LT(v, mesh->numVertices);
        sum = sum + mesh->vertices[v][0];
      }
    if (step == 0) continue;
    const MeshStepView later(view, step);
    for (uint32_t g = 0; g < view.groups; g++) later.groupBox(g, lower, upper);
  }
}

TEST(MeshDamage, DamagedBlocksAreRejectedOrDecodedWithinBounds) {
  Random random(seed + 3);
  for (bool isMoving : {false, true}) {
    const std::vector<Words> blocks = blocksOf(random, isMoving);
    size_t refused = 0, decoded = 0;
    for (int i = 0; i < (isMoving ? 30000 : 60000); i++) {
      Words words = blocks[random.below(uint32_t(blocks.size()))];
      uint8_t* const bytes = (uint8_t*)words.data();
      const uint32_t size = uint32_t(4 * words.size()), motion = ((const MeshHeader*)bytes)->motion;
      // prefer changes to headers and records, which have the largest effect
      const uint32_t ranges[][2] = {
          {0, meshHeaderBytes}, {motion, motion + (isMoving ? 180 : 200)}, {motion, size}, {0, size}};
      for (uint32_t n = 1 + random.below(4); n > 0; n--) {
        const uint32_t* const range = ranges[random.below(4)];
        const uint32_t at = range[0] + random.below(std::min(range[1], size) - range[0]);
        if (random.chance(0.5)) bytes[at] ^= uint8_t(1 << random.below(8));
        else bytes[at] = uint8_t(random.bits());
      }
      if (validateMesh(words.data(), size)) {
        refused++;
        continue;
      }
      decoded++;
      ASSERT_NO_FATAL_FAILURE(decode((const MeshHeader*)words.data()));
    }
    EXPECT_GT(refused, isMoving ? 5000u : 15000u);
    EXPECT_GT(decoded, 3000u);
  }
}

TEST(MeshDamage, RandomBytesAreRejectedOrDecoded) {
  Random random(seed + 4);
  size_t decoded = 0;
  for (int i = 0; i < 100000; i++) {
    Words words(16 + random.below(40));
    for (uint32_t& word : words) word = random.chance(0.3) ? 0 : random.bits();
    MeshHeader& header = *(MeshHeader*)words.data();
    for (float& x : header.origin) x = float(random.normal());
    header.spacings = 0x7F7F7F & random.bits();
    header.motion = 0;
    header.bytes = uint32_t(4 * words.size());
    // one group
    header.counts = meshTagOfCounts() | (random.bits() & 15) | (random.bits() & 3) << 16 | (random.bits() & 15) << 24;
    header.info = meshTagOfInfo() | (random.bits() & 0x0FFF);
    header.groups[0] = (header.counts >> 16 & 31) | (random.chance(0.7) ? 0 : 32);
    header.groups[1] = header.groups[2] = header.groups[3] = 0;
    const uint32_t vertices = meshVertices(header.counts),
                   record = vertices | vertices << 5 | (random.bits() & 7) << 10;
    ((uint8_t*)words.data())[56] = uint8_t(record);
    ((uint8_t*)words.data())[57] = uint8_t(record >> 8);
    if (vertices > 31) continue;
    header.bytes = MeshView(&header).bytes();
    if (header.bytes > 4 * words.size()) continue;
    if (validateMesh(words.data(), 4 * words.size())) continue;
    decoded++;
    ASSERT_NO_FATAL_FAILURE(decode(&header));
  }
  EXPECT_GT(decoded, 20u);
}

}} // namespace programs::test
