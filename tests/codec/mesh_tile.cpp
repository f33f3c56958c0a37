// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Mesh tiles have the triangles, vertices and numbers of their mesh blocks, and boxes that contain their groups. They
 * become the same blocks again. The page tile.md describes them. */

#include "kernels/cvert/decoder/decoded_mesh.h"
#include "kernels/cvert/decoder/validate_mesh.h"
#include "kernels/cvert/conversion/mesh_tile_conversion.h"
#include "codec/format_pages.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <vector>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t seed = 181;

struct Converted {
  alignas(16) uint8_t block[MeshEncoder::maxBytes], tile[maxBytesOfMeshTile], again[MeshEncoder::maxBytes];
  size_t blockBytes, tileBytes;

  const MeshHeader* mesh() const { return (const MeshHeader*)block; }
  const MeshTileHeader* header() const { return (const MeshTileHeader*)tile; }
};

void encode(MeshEncoder& encoder, const std::vector<MeshTriangle>& triangles, uint32_t groupSize, Converted& out) {
  std::vector<uint32_t> ends;
  const uint32_t count = uint32_t(triangles.size());
  for (uint32_t end = groupSize; ends.empty() || ends.back() < count; end += groupSize)
    ends.push_back(std::min(end, count));
  MeshStatistics statistics;
  uint32_t stored;
  out.blockBytes =
      encoder.encode(triangles.data(), ends.data(), uint32_t(ends.size()), 3, out.block, stored, statistics);
  std::memset(out.tile, 0xCC, sizeof(out.tile));
  out.tileBytes = tileOfMesh(out.mesh(), out.tile);
}

// A wavy sheet with holes, in a random direction, whose vertices are on a lattice.
std::vector<MeshTriangle> sheet(Random& random, double size, double roughness, bool hasFarNumbers) {
  double axes[3][3];
  for (auto& axis : axes)
    for (double& x : axis) x = random.uniform(-1, 1);
  const uint32_t width = 1 + random.below(16), number = random.bits() >> 1;
  const double spacing = std::ldexp(1.0, int(random.below(60)) - 30);
  auto pointAt = [&](uint32_t x, uint32_t y, float out[3]) {
    Random own(x + 100 * y + width);
    for (int k = 0; k < 3; k++) {
      const double bend = 0.02 * (double(x) * y - 0.5 * double(x) * x);
      out[k] = float(std::floor(size * (x * axes[0][k] + y * axes[1][k] + bend * axes[2][k]) +
                                roughness * own.uniform(-1, 1) + 100 * k) *
                         spacing +
                     0.0);
    }
  };
  std::vector<MeshTriangle> triangles;
  for (uint32_t y = 0; triangles.size() + 2 * width <= maxMeshTriangles; y++)
    for (uint32_t x = 0; x < width; x++)
      for (uint32_t half = 0; half < 2; half++) {
        if (random.chance(0.1)) continue;
        const uint32_t corners[2][3][2] = {{{x, y}, {x + 1, y}, {x, y + 1}}, {{x + 1, y + 1}, {x, y + 1}, {x + 1, y}}};
        MeshTriangle triangle;
        const uint32_t first = random.below(3);
        for (uint32_t c = 0; c < 3; c++)
          pointAt(corners[half][(c + first) % 3][0], corners[half][(c + first) % 3][1], triangle.corners[c]);
        triangle.number = hasFarNumbers ? random.bits() : number + uint32_t(triangles.size());
        const float(&p)[3][3] = triangle.corners;
        auto areEqual = [](const float* a, const float* b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; };
        if (!areEqual(p[0], p[1]) && !areEqual(p[1], p[2]) && !areEqual(p[2], p[0])) triangles.push_back(triangle);
      }
  return triangles;
}

TEST(MeshTile, HasTheTrianglesOfItsBlockAndBoxesAroundGroups) {
  Random random(seed);
  auto encoder = std::make_unique<MeshEncoder>();
  auto converted = std::make_unique<Converted>();
  std::map<uint32_t, int> bitsOfFields;
  size_t tiles = 0, sheared = 0, largeGroups = 0, without = 0;
  for (int i = 0; i < 3000; i++) {
    SCOPED_TRACE(testing::Message() << "sheet " << i);
    const double sizes[] = {1, 4, 30, 300, 2000}, roughness[] = {0, 1, 10, 100, 2000, 9000};
    const std::vector<MeshTriangle> triangles =
        sheet(random, sizes[random.below(5)], roughness[random.below(6)], i % 5 == 0);
    if (triangles.empty()) continue;
    encode(*encoder, triangles, std::vector<uint32_t>{5, 16, 16, 32}[random.below(4)], *converted);
    if (i % 7 == 0) ((MeshHeader*)converted->block)->info |= meshHasQuads;
    if (i % 7 == 0 && converted->tileBytes) converted->tileBytes = tileOfMesh(converted->mesh(), converted->tile);
    const MeshView view(converted->mesh());
    if (converted->tileBytes == 0) {
      without++;
      continue;
    }
    tiles++;
    const MeshTileView tile(converted->header());
    ASSERT_EQ(tile.tile->bytes, converted->tileBytes);
    ASSERT_TRUE(isMeshTile(tile.tile));
    ASSERT_EQ(tile.tile->meshBytes, converted->blockBytes);
    ASSERT_EQ(tile.tile->surface, 3u);
    ASSERT_EQ(tile.tile->primID, view.block->primID);
    ASSERT_EQ(tile.groups, view.groups);
    sheared += view.isSheared();
    for (uint32_t g = 0; g < view.groups; g++) {
      const DecodedMeshGroup expected(view, g);
      ASSERT_EQ(tile.triangles(g), expected.numTriangles);
      largeGroups += expected.numVertices > 16;
      float lower[3], upper[3];
      for (uint32_t k = 0; k < 3; k++) {
        bitsOfFields[tileGroupFieldBits(tile.record(g), k)]++;
        ASSERT_EQ(tile.plane(g, k), meshPlane(view.block, k, g));
        ASSERT_EQ(tile.plane(g, 3 + k), meshPlane(view.block, k, g) + meshPlane(view.block, 3 + k, g));
      }
      view.groupBox(g, lower, upper);
      for (uint32_t t = 0; t < expected.numTriangles; t++) {
        ASSERT_EQ(tile.number(g, t), expected.numbers[t]);
        for (uint32_t c = 0; c < 3; c++) {
          float p[3];
          ASSERT_EQ(tile.corner(g, t, c), expected.indices[c][t]);
          tile.vertex(g, tile.corner(g, t, c), p);
          for (int k = 0; k < 3; k++) ASSERT_EQ(bitsOfFloat(p[k]), bitsOfFloat(expected.corners[c][k][t]));
        }
      }
    }
    ASSERT_TRUE(bool(validateMesh(converted->tile, sizeof(converted->tile)))) << "files do not contain mesh tiles";
    // back to the same block
    ASSERT_EQ(meshOfTile(converted->header(), *encoder, converted->again), converted->blockBytes);
    ASSERT_EQ(std::memcmp(converted->again, converted->block, converted->blockBytes), 0);
  }
  EXPECT_GT(tiles, 1000u);
  EXPECT_GT(without, 100u);
  EXPECT_GT(sheared, 100u);
  EXPECT_GT(largeGroups, 1000u);
  for (uint32_t bits = 1; bits <= maxTileFieldBits; bits++) EXPECT_GT(bitsOfFields[bits], 50) << bits;
}

TEST(MeshTile, ConstantsMatchThePage) {
  expectConstants("tile.md", {{"bytes of the header", meshTileHeaderBytes},
                              {"bytes of a record", meshTileRecordBytes},
                              {"bytes of an offset", meshTileOffsetBytes},
                              {"triangles of a group, at most", maxTileGroupTriangles},
                              {"bits of a coordinate, at most", maxTileFieldBits},
                              {"bytes after a mesh tile that decoders may read", meshTileReadPadding}});
}

// The mesh block of annotated_blocks.txt.
TEST(MeshTile, MatchesTheAnnotatedTile) {
  const float p[][3] = {{100, 0, 0}, {108, 0, 0}, {108, 16, 0}, {100, 16, 0},
                        {104, 8, 6}, {112, 0, 0}, {116, 0, 0},  {112, 0, 4}};
  const uint32_t corners[][4] = {{0, 1, 4, 40}, {1, 2, 4, 41}, {2, 3, 4, 42}, {3, 0, 4, 43},
                                 {0, 3, 2, 50}, {2, 1, 0, 51}, {5, 6, 7, 52}};
  std::vector<MeshTriangle> triangles;
  for (const uint32_t(&t)[4] : corners) {
    triangles.emplace_back();
    for (int c = 0; c < 3; c++) std::copy_n(p[t[c]], 3, triangles.back().corners[c]);
    triangles.back().number = t[3];
  }
  auto encoder = std::make_unique<MeshEncoder>();
  auto converted = std::make_unique<Converted>();
  MeshStatistics statistics;
  const uint32_t ends[] = {4, 7};
  uint32_t stored;
  encoder->encode(triangles.data(), ends, 2, 3, converted->block, stored, statistics);
  converted->tileBytes = tileOfMesh(converted->mesh(), converted->tile);
  expectAnnotatedBytes(converted->tile, converted->tileBytes, "A mesh tile");
}

}} // namespace programs::test
