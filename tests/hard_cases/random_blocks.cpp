// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Random blocks of the encoder: the bounds that every ISA decodes contain their vertices. */

#include "kernels/cbvh/paper/block_encoder.h"
#include "support/decoding_forms.h"
#include "support/random_sheets.h"

#include <cstdio>

namespace programs::test { namespace {

void* align(void* p) { return (void*)((uintptr_t(p) + 15) & ~uintptr_t(15)); }

// Bounds of the quads below a node, in the frame.
ExactBox boundsOf(const Frame& frame, const Sheet& sheet, uint32_t level, uint32_t height, uint32_t m) {
  const uint32_t size = 1u << (height - level), x0 = mortonX(m) * size, y0 = mortonY(m) * size;
  ExactBox box;
  for (uint32_t y = y0; y <= y0 + size; y++)
    for (uint32_t x = x0; x <= x0 + size; x++) {
      double local[3];
      frame.transform(sheet.vertex(x, y).data(), local);
      box.extend(local);
    }
  return box;
}

// Number of nodes of the block that do not contain their vertices, in one variant of arithmetic.
unsigned violations(Form form, const Block* block, const Frame& frame, const Sheet& sheet, uint32_t level, uint32_t m,
                    const NodeBox& box) {
  unsigned count = !contains(form, box, boundsOf(frame, sheet, level, block->height(), m));
  if (level == block->layout().nodeLevels || level == block->height()) return count;
  const uint32_t word = block->nodes()[nodesOfLevels(level) + m];
  const bool isGroup = isGroupLevel(kindOf(block->info), level, block->layout().nodeLevels);
  if (isGroup && !hasSeparateLeaves(heightsOf(block, m)))
    return count + !contains(form, decodeLattice(form, word, box), boundsOf(frame, sheet, level, block->height(), m));
  for (int c = 0; c < 4; c++)
    count += violations(form, block, frame, sheet, level + 1, 4 * m + uint32_t(c), decode(form, word, c, box));
  return count;
}

TEST(RandomBlocks, BoundsContainVerticesInAllArithmetic) {
  RecordProperty(
      "property",
      "every node and leaf box of random blocks of every shape, 1e-6 to 1e6 wide, near and far, contains its vertices, "
      "with multiply and add fused or not, mirrored or not: the arithmetic of every ISA");
  Random random(81);
  unsigned blocks = 0, sheets = 0;
  for (Kind kind : {Kind::CGRID, Kind::CVOXEL, Kind::CLEAF})
    for (uint32_t height = 0; height <= 6; height++)
      for (Shape shape : allShapes)
        for (int repeat = 0; repeat < (height < 5 ? 12 : 2); repeat++) {
          const double scale = random.magnitude(1e-6, 1e6), away = repeat % 3 ? 0 : scale * random.magnitude(1, 1e5);
          const Sheet sheet = randomSheet(random, shape, height, {scale, {away, -0.3 * away, 0.7 * away}});
          float corners[4][3];
          for (int c = 0; c < 4; c++) // corners of the cage for cLEAF, of the surface otherwise, row by row
            std::copy_n(kind == Kind::CLEAF ? sheet.cage.positions[c < 2 ? c : 5 - c].data()
                                            : sheet.vertex((c & 1) * sheet.quads, (c >> 1) * sheet.quads).data(),
                        3, corners[c]);
          std::vector<Double3> scratch(BlockEncoder::scratchBytes(height) / sizeof(Double3) + 2),
              memory(blockLayout(uint32_t(kind), height).bytes / sizeof(Double3) + 2);
          BlockEncoder encoder(kind, height, (const float(*)[3])sheet.vertices.data(), align(scratch.data()));
          sheets++;
          if (!encoder.fit(corners) || encoder.isDegenerate()) continue;
          blocks++;
          Block* block = (Block*)align(memory.data());
          BlockStatistics stats;
          encoder.encode(block, 0, 0, stats);
          ASSERT_TRUE(stats.maxThickness >= 0 && std::isfinite(stats.maxThickness));
          Frame frame;
          std::copy_n(block->center, 3, frame.center);
          std::copy_n(&block->columns[0][0], 12, &frame.columns[0][0]);
          for (const auto& column : frame.columns)
            for (float c : column) ASSERT_TRUE(std::isfinite(c));
          for (Form form : forms)
            ASSERT_EQ(violations(form, block, frame, sheet, 0, 0, rootBox()), 0u)
                << nameOf(shape) << ", height " << height << ", scale " << scale << " at " << away << ", kind "
                << int(kind);
        }
  std::printf("%u of %u sheets are blocks\n", blocks, sheets);
  EXPECT_GT(blocks, sheets - sheets / 10);
}

}} // namespace programs::test
