// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Layout of blocks: sizes and offsets as FORMAT.md states them, and the block that
 * it shows byte by byte. The table there is read, so the two cannot drift. */

#include "kernels/cbvh/build/block_encoder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

namespace cbvh::test {
namespace {

using namespace embree::cbvh;

constexpr uint32_t headerBytes = 76;

TEST(BlockFormat, SizesAndOffsetsFollowFromKindAndHeight)
{
  uint32_t quads = 1, nodes = 0; // 4^h, (4^h - 1)/3
  for (uint32_t height = 0; height <= maxLevel; height++) {
    const uint32_t width = (1u << height) + 1;
    const uint32_t groups = height ? (quads/4 - 1)/3 : 0; // nodes of h-1 levels
    const BlockLayout grid = blockLayout(kindGrid, height), voxel = blockLayout(kindVoxel, height), leaf = blockLayout(kindLeaf, height);
    SCOPED_TRACE(height);
    EXPECT_EQ(voxel.nodeLevels, height);
    EXPECT_EQ(leaf.nodeLevels, height ? height : 1);
    EXPECT_EQ(grid.nodeLevels, height ? height - 1 : 0);
    EXPECT_EQ(voxel.bytes, headerBytes + 4*nodes);
    EXPECT_EQ(leaf.bytes, headerBytes + (height ? 4*nodes + 2*quads : 12));
    EXPECT_EQ(grid.bytes, headerBytes + 4*groups + 4*(3*width*width + 3));
    for (const BlockLayout& layout : {grid, voxel, leaf}) {
      EXPECT_EQ(layout.leafOffset, headerBytes + 4*layout.nodes);
      EXPECT_EQ(layout.leafOffset + layout.leafBytes, layout.bytes);
      EXPECT_EQ(layout.bytes % 4, 0u);
      EXPECT_EQ(layout.stride % 16, 0u);
      EXPECT_LT(layout.stride - layout.bytes, 16u);
    }
    nodes += quads;
    quads *= 4;
  }
}

TEST(BlockFormat, InfoHoldsEveryFieldAtItsLimits)
{
  for (Kind kind : {Kind::GRID, Kind::VOXEL, Kind::LEAF})
    for (uint32_t height = 0; height <= maxLevel; height++)
      for (uint32_t x : {0u, (256u >> height) - 1})
        for (uint32_t width : {0, 15}) {
          Block block;
          block.info = blockInfo(uint32_t(kind), height, x, x/2) | LeafEncoder::encodeBorderWidth((width + 0.5)/16);
          block.tiling = blockTiling(x, x/2, 0, 0);
          ASSERT_EQ(block.kind(), kind);
          ASSERT_EQ(block.height(), height);
          ASSERT_EQ(blockXOf(block.info), x);
          ASSERT_EQ(blockYOf(block.info), x/2);
          ASSERT_EQ(borderWidthOf(block.info), (width + 1)/16.0f);
          ASSERT_EQ(block.quadsX(), (x + 1) << height);
          ASSERT_EQ(block.quadsY(), (x/2 + 1) << height);
        }
}

TEST(BlockFormat, ParametersEndAtOneForAnyNumberOfBlocks)
{
  for (uint32_t height : {0, 1, 3})
    for (uint32_t last = 0; last < 256u >> height; last++) {
      Block block;
      block.info = blockInfo(kindLeaf, height, last, last);
      block.tiling = blockTiling(last, last, 0, 13); // the last sub-patch of an n-gon
      ASSERT_EQ(block.faceU(float(1u << height)), 1.0f);
      ASSERT_EQ(block.faceV(float(1u << height)), 7.5f);
    }
}

TEST(BlockFormat, MortonOrderIsAOneToOneMapWithXInTheEvenBits)
{
  for (uint32_t y = 0; y < 256; y++)
    for (uint32_t x = 0; x < 256; x++) {
      uint32_t m = 0;
      for (int b = 0; b < 8; b++) m |= ((x >> b) & 1) << (2*b) | ((y >> b) & 1) << (2*b + 1);
      ASSERT_EQ(morton(x, y), m);
      ASSERT_EQ(mortonX(m), x);
      ASSERT_EQ(mortonY(m), y);
    }
}

// Rows "| offset | `bytes` | meaning |" of the section "A block, byte by byte".
std::vector<uint8_t> annotatedBlock()
{
  std::ifstream file(FORMAT_MD);
  std::vector<uint8_t> bytes;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.compare(0, 3, "## ") == 0) inside = line == "## A block, byte by byte";
    unsigned offset;
    if (!inside || std::sscanf(line.c_str(), "| %u | `", &offset) != 1) continue;
    EXPECT_EQ(offset, bytes.size()) << line;
    const size_t begin = line.find('`') + 1;
    std::istringstream row(line.substr(begin, line.find('`', begin) - begin));
    for (unsigned byte; row >> std::hex >> byte;) bytes.push_back(uint8_t(byte));
  }
  return bytes;
}

TEST(BlockFormat, TheAnnotatedBlockIsWhatTheEncoderWrites)
{
  float vertices[9][3];
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) {
      vertices[3*j+i][0] = float(i);
      vertices[3*j+i][1] = float(j);
      vertices[3*j+i][2] = float(i*j);
    }
  const float corners[4][3] = {{0,0,0}, {2,0,0}, {0,2,0}, {2,2,0}};
  std::vector<Double3> scratch(BlockEncoder::scratchBytes(1)/sizeof(Double3) + 2);
  void* aligned = (void*)((uintptr_t(scratch.data()) + 15) & ~uintptr_t(15));
  BlockEncoder encoder(Kind::LEAF, 1, vertices, aligned);
  ASSERT_TRUE(encoder.fit(corners));
  alignas(16) uint8_t bytes[256];
  Block* block = (Block*)bytes;
  BlockStatistics stats;
  encoder.encode(block, 1, 0, stats);
  block->geomID = 3;
  block->primID = 5;
  block->tiling = blockTiling(2, 1, 0, 0);

  const std::vector<uint8_t> written(bytes, bytes + block->layout().bytes);
  std::ostringstream dump;
  for (size_t i = 0; i < written.size(); i++) {
    char text[4];
    std::snprintf(text, sizeof(text), "%02x ", written[i]);
    dump << text << (i % 4 == 3 ? "\n" : "");
  }
  EXPECT_EQ(written, annotatedBlock()) << "the encoder writes\n" << dump.str();
}

} // namespace
} // namespace cbvh::test
