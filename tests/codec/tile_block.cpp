// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Tiles have the vertices, edges and primitive numbers of their blocks, and boxes that contain their leaves. The page
 * tile.md describes them. */

#include "kernels/cvert/decoder/decoded_block.h"
#include "kernels/cvert/decoder/validate.h"
#include "kernels/cvert/conversion/tile_conversion.h"
#include "kernels/cvert/format/block_type.h"
#include "codec/format_pages.h"
#include "support/moving_sheet.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <vector>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t seed = 83;

/* Memory for a tile or block. The encoder must not write after it. */
template<size_t size> struct Bytes {
  alignas(16) uint8_t bytes[size + vertReadPadding];
  size_t used = 0;
  const VertHeader* header() const { return (const VertHeader*)bytes; }
};
typedef Bytes<maxTileBytesOfBlock> TileBytes;
typedef Bytes<maxBlockBytesOfTile> BlockBytes;

size_t tileOf(const BlockBytes& block, VertEncoder& encoder, TileEncoder& tileEncoder, uint8_t* out) {
  const auto decoded = std::make_unique<DecodedBlock>(block.header());
  return tileOfBlock(block.header(), decoded->vertices, encoder, tileEncoder, out);
}

/* Fills an encoder with a bent, rough sheet of `size` coordinates per quad. */
void fill(BlockVertices& out, Random& random, uint32_t quadsX, uint32_t quadsY, double size, double roughness,
          double spacing) {
  double axes[3][3];
  for (auto& axis : axes)
    for (double& x : axis) x = random.uniform(-1, 1);
  for (uint32_t y = 0; y <= quadsY; y++)
    for (uint32_t x = 0; x <= quadsX; x++)
      for (int k = 0; k < 3; k++) {
        const double bend = 0.02 * (double(x) * y - 0.5 * double(x) * x);
        const double at = size * (x * axes[0][k] + y * axes[1][k] + bend * axes[2][k]) + roughness * random.normal();
        out.vertices[y * (quadsX + 1) + x][k] = float(std::floor(at + 1000 * k) * spacing);
      }
}

VertPlacement placement(Random& random, uint32_t quadsX, uint32_t quadsY) {
  const uint32_t region = packRegion(quadsX, quadsY, 16, 32);
  if (random.below(2)) return {region, packPatchQuads(64, 64)};
  return {region, packPatchQuads(64, 64), packEdges(quadsX, quadsY, 1, 1, 1, 5)};
}

TEST(TileBlock, HasTheVerticesOfItsBlockAndBoxesAroundLeaves) {
  Random random(seed);
  auto encoder = std::make_unique<VertEncoder>();
  TileEncoder tileEncoder;
  auto block = std::make_unique<BlockBytes>(), again = std::make_unique<BlockBytes>();
  auto tile = std::make_unique<TileBytes>();
  std::map<uint32_t, int> widths;
  std::map<int, int> scales;
  size_t without = 0;
  for (int i = 0; i < 5000; i++) {
    const uint32_t quadsX = 1 + random.below(16), quadsY = 1 + random.below(16);
    const double sizes[] = {2, 20, 200, 700, 3000, 7000, 13000}, roughness[] = {0, 1, 10, 100, 2000};
    encoder->setSize(packRegion(quadsX, quadsY, 0, 0));
    fill(*encoder, random, quadsX, quadsY, sizes[random.below(7)], roughness[random.below(5)],
         std::ldexp(1.0, int(random.below(60)) - 30));
    const bool isBad = i % 17 == 0;
    if (isBad) encoder->vertices[random.below(encoder->numVertices())][i % 3] = i % 2 ? NAN : INFINITY;
    const bool isLossless = i % 13 == 0;
    if (isLossless) // more bits than coordinates have
      for (uint32_t v = 0; v < encoder->numVertices(); v++) encoder->vertices[v][i % 3] *= 1.0001f;
    VertStatistics statistics;
    block->used = encoder->encode(placement(random, quadsX, quadsY), block->bytes, statistics);
    if (block->used == 0) continue;
    ((VertHeader*)block->bytes)->primID = uint32_t(i);
    ((VertHeader*)block->bytes)->surface = uint32_t(2 * i);
    const size_t bytes = tileOf(*block, *encoder, tileEncoder, tile->bytes);
    if (bytes == 0) {
      ASSERT_LT(quadsX * quadsY, minTileQuads);
      without++;
      continue;
    }
    const VertHeader* header = tile->header();
    ASSERT_TRUE(isTile(header->info));
    ASSERT_FALSE(isTile(block->header()->info));
    ASSERT_EQ(tileBytes(header), bytes);
    ASSERT_EQ(header->region, block->header()->region);
    ASSERT_EQ(header->patchQuads, block->header()->patchQuads);
    ASSERT_EQ(header->primID, uint32_t(i));
    ASSERT_EQ(header->surface, uint32_t(2 * i));
    ASSERT_EQ(edgesOf(header).low, edgesOf(block->header()).low);
    ASSERT_EQ(edgesOf(header).high, edgesOf(block->header()).high);
    widths[tileVertexBytes(header)]++;
    scales[tileScale(header)]++;
    const auto expected = std::make_unique<DecodedBlock>(block->header()),
               decoded = std::make_unique<DecodedBlock>(header);
    for (uint32_t v = 0; v < encoder->numVertices(); v++)
      for (int k = 0; k < 3; k++) {
        const float a = expected->vertices[v][k], b = decoded->vertices[v][k];
        ASSERT_TRUE(std::memcmp(&a, &b, sizeof(a)) == 0 || (std::isnan(a) && std::isnan(b)) || (a == 0 && b == 0))
            << "sheet " << i << ", vertex " << v << ": " << a << " " << b;
      }
    for (uint32_t leaf = 0; leaf < 32; leaf++) {
      const uint32_t x0 = leafQuadsX * (leaf & 3u), y0 = leafQuadsY * (leaf >> 2);
      const bool exists = x0 < quadsX && y0 < quadsY;
      ASSERT_EQ((tileLeaves(header->region) >> leaf) & 1u, uint32_t(exists));
      if (!exists) continue;
      for (int k = 0; k < 3; k++) {
        const double unit = double(tileBoxUnit(header, k)), origin = double(header->origin[k]);
        const double lower = origin + unit * tilePlane(header, leaf, k, 0),
                     upper = origin + unit * tilePlane(header, leaf, k, 1);
        for (uint32_t y = y0; y <= std::min(y0 + leafQuadsY, quadsY); y++)
          for (uint32_t x = x0; x <= std::min(x0 + leafQuadsX, quadsX); x++) {
            const float* p = decoded->vertex(x, y);
            if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))) continue;
            ASSERT_LE(lower, double(p[k])) << "sheet " << i << ", leaf " << leaf;
            ASSERT_GE(upper, double(p[k])) << "sheet " << i << ", leaf " << leaf;
          }
      }
    }
    ASSERT_TRUE(bool(validateVert(tile->bytes, sizeof(tile->bytes)))) << "files do not contain tiles";
    // back to the same block
    again->used = blockOfTile(header, *encoder, again->bytes);
    ASSERT_EQ(again->used, block->used);
    ASSERT_EQ(std::memcmp(again->bytes, block->bytes, block->used), 0) << "sheet " << i;
  }
  for (uint32_t width : {2u, 3u, 4u, 5u, tileFloatBytes}) EXPECT_GT(widths[width], 50) << width;
  for (int scale : {1, 2, 4, 8}) EXPECT_GT(scales[scale], 20) << scale;
  EXPECT_GT(without, 300u);
}

// Residuals of two axes that together have more than 32 bits, and few on the third.
TEST(TileBlock, HasTheVerticesOfBlocksThatAreRoughAlongTwoAxes) {
  Random random(seed + 2);
  auto encoder = std::make_unique<VertEncoder>();
  TileEncoder tileEncoder;
  auto tile = std::make_unique<TileBytes>();
  const VertPlacement placement(packRegion(16, 16, 0, 0), packPatchQuads(16, 16));
  std::map<uint32_t, int> widths;
  for (int i = 0; i < 300; i++) {
    encoder->setSize(placement.region);
    const uint32_t smooth = random.below(3), bits = 10 + random.below(9);
    for (uint32_t v = 0; v < encoder->numVertices(); v++)
      for (uint32_t k = 0; k < 3; k++) encoder->vertices[v][k] = k == smooth ? 0.0f : float(random.below(1u << bits));
    encoder->computeBounds();
    const auto vertices = std::make_unique<BlockVertices>(*encoder);
    ASSERT_GT(tileEncoder.encode(*encoder, placement, tile->bytes), 0u);
    widths[tileVertexBytes(tile->header())]++;
    const auto decoded = std::make_unique<DecodedBlock>(tile->header());
    for (uint32_t v = 0; v < vertices->numVertices(); v++)
      for (int k = 0; k < 3; k++) ASSERT_EQ(decoded->vertices[v][k], vertices->vertices[v][k]) << i << ", " << v;
  }
  for (uint32_t width : {3u, 4u, 5u, tileFloatBytes}) EXPECT_GT(widths[width], 20) << width;
}

TEST(TileBlock, KeepsPrimitiveNumbers) {
  Random random(seed + 1);
  auto encoder = std::make_unique<VertEncoder>();
  TileEncoder tileEncoder;
  NumbersEncoder numbers;
  auto block = std::make_unique<BlockBytes>(), again = std::make_unique<BlockBytes>();
  auto tile = std::make_unique<TileBytes>();
  size_t tables = 0, pairs = 0;
  for (int i = 0; i < 300; i++) {
    const uint32_t quadsX = 9 + random.below(8), quadsY = 9 + random.below(8);
    QuadNumbers patch;
    const bool areTriangles = i % 2, areFar = i % 3 == 0, areMixed = i % 5 == 0;
    patch.numbering = areTriangles ? primIDsOfTriangles : 0u;
    patch.width = quadsX;
    for (uint32_t q = 0; q < quadsX * quadsY; q++) {
      patch.numbers.push_back(100 + (areMixed ? 2 * random.below(5000) : 2 * q));
      if (areTriangles && areFar) {
        patch.seconds.push_back(patch.numbers.back() + 7000);
        patch.firstCorners.push_back(0);
      }
    }
    numbers.choosePattern(patch, 0, 0, quadsX, quadsY);
    encoder->setSize(packRegion(quadsX, quadsY, 0, 0));
    fill(*encoder, random, quadsX, quadsY, 20, 1, 0.125);
    VertStatistics statistics;
    block->used = encoder->encode(VertPlacement(packRegion(quadsX, quadsY, 0, 0), numbers.numbering, numbers.pattern),
                                  block->bytes, statistics);
    block->used = numbers.finish((VertHeader*)block->bytes, block->used);
    ASSERT_GT(tileOf(*block, *encoder, tileEncoder, tile->bytes), 0u);
    tables += haveTable(numbers.numbering);
    pairs += haveTrianglePairs(numbers.numbering);
    for (uint32_t y = 0; y < quadsY; y++)
      for (uint32_t x = 0; x < quadsX; x++)
        for (bool isSecond : {false, true})
          ASSERT_EQ(primitiveOfQuad(tile->header(), x, y, isSecond).primID,
                    primitiveOfQuad(block->header(), x, y, isSecond).primID);
    again->used = blockOfTile(tile->header(), *encoder, again->bytes);
    ASSERT_EQ(vertBytes(again->header()), vertBytes(block->header()));
    ASSERT_EQ(std::memcmp(again->bytes, block->bytes, vertBytes(block->header())), 0);
  }
  EXPECT_GT(tables, 30u);
  EXPECT_GT(pairs, 30u);
}

// Of blocks or tiles whose vertices are finite.
void expectEqualSteps(const VertHeader* expected, const VertHeader* found) {
  ASSERT_EQ(motionOf(found).begin, motionOf(expected).begin);
  ASSERT_EQ(motionOf(found).end, motionOf(expected).end);
  ASSERT_EQ(motionOf(found).numSteps, motionOf(expected).numSteps);
  for (uint32_t s = 0; s < motionOf(expected).numSteps; s++) {
    const auto a = std::make_unique<DecodedBlock>(expected, s), b = std::make_unique<DecodedBlock>(found, s);
    for (uint32_t v = 0; v < (a->quadsX + 1) * (a->quadsY + 1); v++)
      for (int k = 0; k < 3; k++) ASSERT_EQ(a->vertices[v][k], b->vertices[v][k]) << "step " << s << ", vertex " << v;
  }
}

TEST(TileBlock, MovingTilesHaveTheStepsOfTheirBlocks) {
  Random random(seed + 3);
  auto encoder = std::make_unique<MotionEncoder>();
  auto tileEncoder = std::make_unique<MovingTileEncoder>();
  NumbersEncoder numbers;
  size_t without = 0, withNumbers = 0, tiles = 0;
  for (int i = 0; i < 600; i++) {
    const uint32_t quadsX = 5 + random.below(12), quadsY = 5 + random.below(12);
    const MovingSheet sheet(random, quadsX, quadsY, i);
    const uint32_t steps = uint32_t(sheet.steps.size()), region = packRegion(quadsX, quadsY, 16, 0);
    VertPlacement at = placement(random, quadsX, quadsY);
    const bool haveNumbers = i % 3 == 0;
    if (haveNumbers) {
      QuadNumbers patch;
      patch.numbering = i % 2 ? primIDsOfTriangles : 0u;
      patch.width = quadsX;
      for (uint32_t q = 0; q < quadsX * quadsY; q++) patch.numbers.push_back(2 * random.below(5000));
      numbers.choosePattern(patch, 0, 0, quadsX, quadsY);
      at = VertPlacement(region, numbers.numbering, numbers.pattern);
    }
    std::vector<uint32_t> memory[3];
    for (auto& bytes : memory) bytes.resize(maxBytesOfMovingForms(steps) / sizeof(uint32_t));
    VertHeader *const block = (VertHeader*)memory[0].data(), *const tile = (VertHeader*)memory[1].data(),
                      *const again = (VertHeader*)memory[2].data();
    encoder->begin(at, 0.25f, 0.75f, steps, (uint8_t*)block);
    for (const MovingSheet::Step& step : sheet.steps) {
      std::memcpy(encoder->vertices(), step.data(), sizeof(step[0]) * step.size());
      encoder->addStep();
    }
    MotionStatistics statistics, ofTile;
    const size_t size = encoder->finish(statistics);
    ASSERT_GT(size, 0u);
    EXPECT_EQ(laterStepBytes(block), statistics.stepBytes);
    EXPECT_EQ(isAnyStepRaw(block), bool(statistics.raw));
    block->surface = uint32_t(i);
    block->primID = uint32_t(3 * i);
    if (haveNumbers) numbers.finish(block, size);
    const size_t bytes = movingTileOfBlock(block, *tileEncoder, (uint8_t*)tile, ofTile);
    bool areFinite = true;
    for (const MovingSheet::Step& step : sheet.steps)
      for (const auto& p : step)
        for (float c : p) areFinite &= std::isfinite(c);
    ASSERT_EQ(bytes != 0, areFinite && quadsX * quadsY >= minTileQuads) << "sheet " << i;
    if (bytes == 0) {
      without++;
      continue;
    }
    tiles++;
    ASSERT_EQ(tileBytes(tile), bytes);
    ASSERT_TRUE(isTile(tile->info) && isMoving(tile->info));
    ASSERT_EQ(tile->surface, uint32_t(i));
    ASSERT_EQ(tile->primID, block->primID);
    EXPECT_EQ(laterStepBytes(tile), ofTile.stepBytes);
    ASSERT_NO_FATAL_FAILURE(expectEqualSteps(block, tile)) << "sheet " << i;
    for (uint32_t y = 0; y < quadsY && haveNumbers; y++)
      for (uint32_t x = 0; x < quadsX; x++)
        for (bool isSecond : {false, true})
          ASSERT_EQ(primitiveOfQuad(tile, x, y, isSecond).primID, primitiveOfQuad(block, x, y, isSecond).primID);
    withNumbers += haveNumbers && haveTable(numbers.numbering);
    ASSERT_GT(movingBlockOfTile(tile, *encoder, (uint8_t*)again, statistics), 0u);
    ASSERT_EQ(vertBytes(again), vertBytes(block));
    ASSERT_EQ(std::memcmp(again, block, vertBytes(block)), 0) << "sheet " << i;
  }
  EXPECT_GT(tiles, 250u);
  EXPECT_GT(without, 100u);
  EXPECT_GT(withNumbers, 50u);
}

TEST(TileBlock, ConstantsMatchThePage) {
  expectConstants("tile.md", {{"type of a tile in the tree", TILE_BLOCK},
                              {"quads of a leaf along u", leafQuadsX},
                              {"quads of a leaf along v", leafQuadsY},
                              {"quads of a tile, at least", minTileQuads},
                              {"bytes of a packed vertex, at most", maxTileVertexBytes},
                              {"bytes of a vertex as floats", tileFloatBytes},
                              {"bits of a coordinate", tileExtentBits},
                              {"leaves per part of the boxes", leavesPerPart}});
}

// Vertex (i,j) is at (100 + 8 i, 8 j, i j), but vertex (4,4) is 40 lower.
TEST(TileBlock, MatchesTheAnnotatedTile) {
  auto encoder = std::make_unique<VertEncoder>();
  for (uint32_t j = 0; j <= 8; j++)
    for (uint32_t i = 0; i <= 8; i++) {
      float* p = encoder->vertices[9 * j + i];
      p[0] = float(100 + 8 * i);
      p[1] = float(8 * j);
      p[2] = float(i * j) - (i == 4 && j == 4 ? 40.0f : 0.0f);
    }
  encoder->setSize(packRegion(8, 8, 16, 0));
  encoder->computeBounds();
  auto tile = std::make_unique<TileBytes>();
  TileEncoder tileEncoder;
  tile->used = tileEncoder.encode(*encoder, VertPlacement(packRegion(8, 8, 16, 0), packPatchQuads(24, 8)), tile->bytes);
  ((VertHeader*)tile->bytes)->surface = 3;
  ((VertHeader*)tile->bytes)->primID = 5;
  expectAnnotatedBytes(tile->bytes, tile->used, "A tile");
}

}} // namespace programs::test
