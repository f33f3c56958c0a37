// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Sizes and constants must equal the tables of kernels/cbvh/paper/README.md, annotated blocks those of
 * annotated_blocks.txt. */

#include "codec/format_pages.h"
#include "support/encoded_block.h"

#include "kernels/cbvh/base/leaf_type.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

namespace programs::test { namespace {

using namespace embree::cbvh;

constexpr uint32_t headerBytes = 76;

TEST(BlockFormat, SizesAndOffsetsMatchFormulas) {
  uint32_t quads = 1, nodes = 0; // 4^h, (4^h - 1)/3
  for (uint32_t height = 0; height <= maxFramedLevel; height++) {
    const uint32_t width = (1u << height) + 1;
    const uint32_t groups = height ? (quads / 4 - 1) / 3 : 0; // number of nodes in h-1 levels
    const BlockLayout grid = blockLayout(kindGrid, height), voxel = blockLayout(kindVoxel, height),
                      leaf = blockLayout(kindLeaf, height);
    SCOPED_TRACE(height);
    EXPECT_EQ(voxel.nodeLevels, height);
    EXPECT_EQ(leaf.nodeLevels, height ? height : 1);
    EXPECT_EQ(grid.nodeLevels, height ? height - 1 : 0);
    EXPECT_EQ(voxel.bytes, headerBytes + 4 * nodes);
    EXPECT_EQ(leaf.bytes, headerBytes + (height ? 4 * nodes + 2 * quads : 12));
    EXPECT_EQ(grid.bytes, headerBytes + 4 * groups + 4 * (3 * width * width + 3));
    for (const BlockLayout& layout : {grid, voxel, leaf}) {
      EXPECT_EQ(layout.leafOffset, headerBytes + 4 * layout.numNodes);
      EXPECT_EQ(layout.leafOffset + layout.leafBytes, layout.bytes);
      EXPECT_EQ(layout.bytes % 4, 0u);
      EXPECT_EQ(layout.stride % 16, 0u);
      EXPECT_LT(layout.stride - layout.bytes, 16u);
    }
    nodes += quads;
    quads *= 4;
  }
}

TEST(BlockFormat, InfoRoundTripsLimitsOfEveryField) {
  for (Kind kind : {Kind::CGRID, Kind::CVOXEL, Kind::CLEAF})
    for (uint32_t height = 0; height <= maxFramedLevel; height++)
      for (uint32_t x : {0u, (256u >> height) - 1})
        for (uint32_t width : {0, 15}) {
          Block block;
          block.info = blockInfo(uint32_t(kind), height, x, x / 2) | LeafEncoder::encodeBorderWidth((width + 0.5) / 16);
          block.tiling = blockTiling(x, x / 2, 0, 0);
          ASSERT_EQ(block.kind(), kind);
          ASSERT_EQ(block.height(), height);
          ASSERT_EQ(blockXOf(block.info), x);
          ASSERT_EQ(blockYOf(block.info), x / 2);
          ASSERT_EQ(borderWidthOf(block.info), (width + 1) / 16.0f);
          ASSERT_EQ(block.quadsX(), (x + 1) << height);
          ASSERT_EQ(block.quadsY(), (x / 2 + 1) << height);
        }
}

TEST(BlockFormat, ParametersEndAtOneForAnyTiling) {
  for (uint32_t height : {0, 1, 3})
    for (uint32_t last = 0; last < 256u >> height; last++) {
      Block block;
      block.info = blockInfo(kindLeaf, height, last, last);
      block.tiling = blockTiling(last, last, 0, 13); // the last sub-patch of an n-gon
      ASSERT_EQ(block.faceU(float(1u << height)), 1.0f);
      ASSERT_EQ(block.faceV(float(1u << height)), 7.5f);
    }
}

TEST(BlockFormat, MortonOrderIsBijectiveWithXInEvenBits) {
  for (uint32_t y = 0; y < 256; y++)
    for (uint32_t x = 0; x < 256; x++) {
      uint32_t m = 0;
      for (int b = 0; b < 8; b++) m |= ((x >> b) & 1) << (2 * b) | ((y >> b) & 1) << (2 * b + 1);
      ASSERT_EQ(morton(x, y), m);
      ASSERT_EQ(mortonX(m), x);
      ASSERT_EQ(mortonY(m), y);
    }
}

// Rays can hit a triangle with a vertex at infinity, but not one with NaN.
TEST(BlockFormat, CGridStoresVerticesExactlyAndNonFiniteOnesAsNaN) {
  const uint32_t height = 2, width = (1u << height) + 1, count = width * width;
  const float infinity = std::numeric_limits<float>::infinity(),
              corners[4][3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}};
  std::vector<float> vertices;
  for (uint32_t i = 0; i < count; i++)
    vertices.insert(vertices.end(), {float(i % width), float(i / width), 0.1f * float(i * i % 7)});
  const struct {
    uint32_t vertex, axis;
    float value;
  } bad[] = {{3, 0, infinity}, {7, 1, -infinity}, {12, 2, infinity}, {24, 2, std::nanf("")}};
  for (const auto& b : bad) vertices[3 * b.vertex + b.axis] = b.value;
  const EncodedBlock encoded(Kind::CGRID, height, vertices, corners);
  ASSERT_TRUE(encoded);
  std::vector<float> stored(3 * count);
  std::memcpy(stored.data(), encoded.get()->leaves(), stored.size() * sizeof(float));
  for (uint32_t i = 0; i < count; i++) {
    const bool isBad = std::any_of(std::begin(bad), std::end(bad), [&](const auto& b) { return b.vertex == i; });
    for (uint32_t k = 0; k < 3; k++) {
      if (isBad) {
        EXPECT_TRUE(std::isnan(stored[k * count + i]))
            << "vertex " << i << ", axis " << k << ": " << stored[k * count + i];
      } else {
        EXPECT_EQ(stored[k * count + i], vertices[3 * i + k]) << "vertex " << i << ", axis " << k;
      }
    }
  }
}

TEST(BlockFormat, ConstantsMatchPage) {
  expectConstants(paperPage, {{"format version, `formatVersion`", formatVersion},
                              {"alignment of a block, bytes", blockAlignment},
                              {"type of a block in the tree", FRAMED_BLOCK},
                              {"bytes of the header", blockHeaderBytes},
                              {"height of a block, at most", maxFramedLevel}});
}

// Rows "| h | cGRID | cVOXEL | cLEAF |".
TEST(BlockFormat, SizesMatchPage) {
  uint32_t rows = 0;
  std::istringstream lines(section(paperPage, "Sizes"));
  for (std::string line; std::getline(lines, line);) {
    unsigned height, bytes[3];
    if (std::sscanf(line.c_str(), "| %u | %u | %u | %u |", &height, bytes, bytes + 1, bytes + 2) != 4) continue;
    EXPECT_EQ(height, rows++);
    for (uint32_t kind = 0; kind < numKindFormats; kind++)
      EXPECT_EQ(bytes[kind], blockLayout(kind, height).bytes) << line;
  }
  EXPECT_EQ(rows, maxFramedLevel + 1);
}

// Vertices (i, j, z), row by row, of a block in annotated_blocks.txt.
void expectAnnotated(const std::string& heading, uint32_t height, const std::vector<float>& z) {
  const uint32_t quads = 1u << height, width = quads + 1;
  ASSERT_EQ(z.size(), width * width);
  std::vector<float> vertices;
  for (uint32_t v = 0; v < z.size(); v++) vertices.insert(vertices.end(), {float(v % width), float(v / width), z[v]});
  const float n = float(quads), corners[4][3] = {{0, 0, 0}, {n, 0, 0}, {0, n, 0}, {n, n, 0}};
  EncodedBlock encoded(Kind::CLEAF, height, vertices, corners, 1, 0);
  ASSERT_TRUE(encoded);
  Block* block = encoded.get();
  block->surface = 3;
  block->primID = 5;
  block->tiling = blockTiling(2, 1, 0, 0);
  expectAnnotatedBytes(block, blockLayout(kindLeaf, height).bytes, heading);
}

TEST(BlockFormat, EncoderWritesAnnotatedLattice) { expectAnnotated("A lattice", 1, {0, 0, 0, 0, 1, 2, 0, 2, 4}); }

TEST(BlockFormat, EncoderWritesAnnotatedGroupOfSeparateLeaves) {
  expectAnnotated("A group of separate leaves", 1, {0, 0.25f, 1.5f, 0.5f, 1, 0, 1, 1.75f, NAN});
}

TEST(BlockFormat, EncoderWritesAnnotatedBlockOfTwoLevels) {
  std::vector<float> z;
  for (int j = 0; j <= 4; j++)
    for (int i = 0; i <= 4; i++) z.push_back(float(i * i + 2 * j) / 4);
  expectAnnotated("Two levels of words", 2, z);
}

}} // namespace programs::test
