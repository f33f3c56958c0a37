// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares the traversal's decoder of cVERT with the scalar one, cvert/decoder/decoded_block.h: random blocks of all
 * sizes, all groups exactly, because no operation rounds. Compiled once for every ISA, outside of the library. */

#include "kernels/cvert/encoder/block_encoder.h"
#include "kernels/cvert/decoder/decoded_block.h"
#include "kernels/cbvh/base/block_validity.h"
#include "kernels/cbvh/exact/decoder.h"
#include "kernels/cbvh/exact/triangles.h"
#include "support/random.h"

#include <memory>
#include <vector>

// for isa_check.cpp
extern const char* const programIsa;
const char* const programIsa = TEST_ISA;

namespace programs::test { namespace {

using namespace embree::cbvh;

using namespace cvert;

// Vertices with residuals of all sizes; some blocks are raw. spacing: of their lattice, if isSnapped
void fillRandomly(Random& random, VertEncoder& encoder, uint32_t quadsX, uint32_t quadsY, double roughness,
                  float spacing, bool isSnapped) {
  double axis[3][3], origin[3];
  for (int k = 0; k < 3; k++) {
    origin[k] = std::floor(random.uniform(-1e5, 1e5));
    for (double* a : {axis[0], axis[1], axis[2]}) a[k] = random.uniform(-60, 60);
  }
  for (uint32_t y = 0; y <= quadsY; y++)
    for (uint32_t x = 0; x <= quadsX; x++) {
      const double h = roughness * random.normal();
      // 20: not along a normal
      auto place = [&](int k) {
        return x * axis[0][k] + y * axis[1][k] + (roughness == 20 ? 1000 * random.normal() : h * axis[2][k]);
      };
      for (int k = 0; k < 3; k++)
        encoder.vertices[y * (quadsX + 1) + x][k] =
            float((isSnapped ? origin[k] + std::floor(place(k)) : 0.01 * origin[k] + place(k)) * spacing);
    }
  if (random.chance(0.1)) encoder.vertices[random.below((quadsX + 1) * (quadsY + 1))][0] = INFINITY;
}

TEST(VertDecoding, GroupsMatchScalarDecoder) {
  using namespace embree::isa::cbvh;
  Random random(95);
  auto encoder = std::make_unique<VertEncoder>();
  std::vector<uint8_t> memory(VertEncoder::maxBytes + 32);
  uint8_t* bytes = (uint8_t*)((uintptr_t(memory.data()) + 15) & ~uintptr_t(15));
  unsigned raw = 0, packed = 0, sheared = 0, byAxis = 0, withRemainders = 0;
  for (int i = 0; i < 3000; i++) {
    const uint32_t quadsX = 1 + random.below(16), quadsY = 1 + random.below(16);
    VertPlacement place(packRegion(quadsX, quadsY, 0, 0), packPatchQuads(quadsX, quadsY));
    if (i % 3 == 0) place = VertPlacement(place.region, place.patchQuads, packEdges(1, 2, 3, 4, 1, 0));
    const float spacing = std::ldexp(1.0f, int(random.below(20)) - 10);
    fillRandomly(random, *encoder, quadsX, quadsY, std::vector<double>{0, 0.1, 1, 10, 20}[i % 5], spacing, i % 7 < 5);
    VertStatistics statistics;
    ASSERT_GT(encoder->encode(place, bytes, statistics), 0u);
    (statistics.raw ? raw : packed)++;
    const VertHeader* block = (const VertHeader*)bytes;
    byAxis += !statistics.raw && isByAxis(block->word);
    withRemainders += hasRemainders(block->info);
    const auto expected = std::make_unique<DecodedBlock>(block);
    const VertLayout layout = vertLayout(place.region, place.info());
    const VertDecoder decoder(block);
    VertBlockEntry entry;
    decoder.decode(entry);
    sheared += !statistics.raw && shearSlope(block->info, 1) != 0;
    uint32_t lanes = 0;
    for (uint32_t n = layout.groups; n > 0; n--) { // in any order
      const uint32_t g = (n * 7 + 3) % layout.groups, lane = g % layout.groupsX + 4 * (g / layout.groupsX);
      lanes |= 1u << lane;
      float lower[3], upper[3];
      expected->groupBox(g, lower, upper);
      for (int k = 0; k < 3; k++) {
        ASSERT_EQ(entry.planes[k].at[0][lane], lower[k]);
        ASSERT_EQ(entry.planes[k].at[1][lane], upper[k]);
      }
      CellVertices group;
      decoder.vertices(entry, lane, group);
      for (uint32_t q = 0; q < 16; q++)
        for (uint32_t c = 0; c < 4; c++) {
          const uint32_t x = std::min(groupQuads * (g % layout.groupsX) + q % 4 + c % 2, quadsX),
                         y = std::min(groupQuads * (g / layout.groupsX) + q / 4 + c / 2, quadsY);
          for (int k = 0; k < 3; k++) {
            const float a = group.at[k][laneOfCorner(q, c)], b = expected->vertex(x, y)[k];
            ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b)))
                << a << " for " << b << ": block " << i << " of " << quadsX << " x " << quadsY
                << (statistics.raw ? ", raw" : "") << ", group " << g << ", quad " << q << ", corner " << c << ", axis "
                << k;
          }
        }
    }
    ASSERT_EQ(entry.lanes, lanes) << quadsX << " x " << quadsY;
    ASSERT_EQ(entry.shearedAxis, statistics.raw ? 3 : shearedAxis(block->info));
    for (int k = 0; k < 3; k++) {
      ASSERT_EQ(entry.origin[k], block->origin[k]);
      const int i = (k - entry.shearedAxis + 3) % 3; // the sheared axis, or the number of axes after it
      ASSERT_EQ(entry.shear[k], statistics.raw ? 0.0f : i == 0 ? 1.0f : shearSlope(block->info, i) / 16.0f);
    }
  }
  EXPECT_GT(raw, 100u);
  EXPECT_GT(packed, 2000u);
  EXPECT_GT(sheared, 500u);
  EXPECT_GT(byAxis, 100u);
  EXPECT_GT(withRemainders, 500u);
}

// Vertices on few lattice points: many are equal, collinear, or coplanar with the ray. Triangles that contain the ray
// by exact signs must be found, although sides round to 0.
TEST(VertTriangles, TrianglesThatContainTheRayAreFound) {
  using namespace embree::isa::cbvh;
  using embree::Vec3fa;
  Random random(96);
  size_t found = 0, onLines = 0, bad = 0;
  for (int i = 0; i < 20000; i++) {
    CellVertices cell;
    const unsigned width = 2 + random.below(30);
    // in every other case all triangles are degenerate, and shearing rounds its vertices apart
    const bool isLine = i % 2;
    float along[VertTables::lanes], step[3];
    for (float& x : along) x = float(random.below(8));
    for (float& x : step) x = float(int(random.below(40)) - 20) / 128;
    for (int k = 0; k < 3; k++)
      for (int v = 0; v < VertTables::lanes; v++)
        cell.at[k][v] = (isLine ? along[v] * step[k] : float(random.below(width)) / 128) + (k == 2 ? 1 : 0);
    const bool hole = i % 7 == 0;
    if (hole) cell.at[i % 3][random.below(cellVertices)] = NAN;
    // at a vertex, or at the middle of two
    const unsigned a = random.below(cellVertices), b = random.below(cellVertices);
    float org[3], dir[3];
    for (int k = 0; k < 3; k++) {
      org[k] = float(random.below(64)) / 64 - (k == 2 ? 4 : 0);
      dir[k] = 0.5f * (cell.at[k][a] + cell.at[k][b]) - org[k];
    }
    if (!(std::fabs(dir[0]) + std::fabs(dir[1]) + std::fabs(dir[2]) > 0)) continue;
    const embree::Ray ray(Vec3fa(org[0], org[1], org[2]), Vec3fa(dir[0], dir[1], dir[2]), 0.0f, INFINITY);
    VertRay pre;
    pre.set(ray);
    const GroupTriangles triangles(pre, cell);
    for (uint32_t index = 0; index < 32; index++) {
      const VertTriangle triangle(cell, index);
      const VertTriangle::Sides stored = triangles.sides(index), sides = triangle.sides(pre);
      if (!hole) {
        ASSERT_TRUE(stored.w0 == sides.w0 && stored.w1 == sides.w1 && stored.w2 == sides.w2 && stored.sum == sides.sum)
            << "case " << i << ", triangle " << index;
      }
      const double t = triangle.distance(pre, triangle.normal(), 0.0f);
      const bool isMet = triangle.containsExactly(pre) && t >= 0;
      if (!isMet) {
        ASSERT_FALSE((triangles.mask >> index & 1) && haveExactSigns(sides)) << "case " << i << ", triangle " << index;
        bad++;
        continue;
      }
      ASSERT_TRUE(triangles.mask >> index & 1) << "case " << i << ", triangle " << index << ", at " << t;
      found++;
      onLines += !haveExactSigns(sides);
    }
  }
  EXPECT_GT(found, 20000u);
  EXPECT_GT(onLines, 300u);
  EXPECT_GT(bad, 1000u);
}

// A ray along z through lattice points, in integers: a triangle contains the ray if it is inside or on an edge,
// unless the triangle is degenerate seen along the ray.
TEST(VertTriangles, ContainInnerPointsAndEdges) {
  using namespace embree::isa::cbvh;
  Random random(98);
  size_t inside = 0, onEdges = 0, lines = 0;
  for (int i = 0; i < 2000; i++) {
    CellVertices cell;
    for (auto& axis : cell.at)
      for (float& x : axis) x = float(random.below(7));
    const int px = int(random.below(7)), py = int(random.below(7));
    VertRay pre;
    pre.set(embree::Ray(embree::Vec3fa(float(px), float(py), -1), embree::Vec3fa(0, 0, 1), 0.0f, INFINITY));
    for (uint32_t index = 0; index < 32; index++) {
      const uint32_t corners[2][3] = {{0, 1, 2}, {2, 1, 3}}; // 00, 10, 01 and 01, 10, 11
      int x[3], y[3];
      for (int v = 0; v < 3; v++) {
        x[v] = int(cell.at[0][laneOfCorner(index >> 1, corners[index & 1][v])]);
        y[v] = int(cell.at[1][laneOfCorner(index >> 1, corners[index & 1][v])]);
      }
      const auto area = [](int ax, int ay, int bx, int by, int cx, int cy) {
        return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
      };
      const int all = area(x[0], y[0], x[1], y[1], x[2], y[2]);
      const int parts[3] = {area(px, py, x[1], y[1], x[2], y[2]), area(x[0], y[0], px, py, x[2], y[2]),
                            area(x[0], y[0], x[1], y[1], px, py)};
      // parts with the same sign sum up to the whole
      const bool isInside = all != 0 && std::abs(parts[0]) + std::abs(parts[1]) + std::abs(parts[2]) == std::abs(all);
      ASSERT_EQ(VertTriangle(cell, index).containsExactly(pre), isInside) << "case " << i << ", triangle " << index;
      inside += isInside;
      onEdges += isInside && parts[0] * parts[1] * parts[2] == 0;
      lines += all == 0;
    }
  }
  EXPECT_GT(inside, 5000u);
  EXPECT_GT(onEdges, 1000u);
  EXPECT_GT(lines, 1000u);
}

// The rays of a packet through and past vertices, including values that are not finite.
template<int K>
void comparePacketsWithRays() {
  using namespace embree::isa::cbvh;
  using embree::Vec3fa;
  Random random(97);
  size_t found = 0;
  for (int i = 0; i < 4000; i++) {
    CellVertices cell;
    const unsigned width = 2 + random.below(30);
    for (int k = 0; k < 3; k++)
      for (float& x : cell.at[k]) x = float(random.below(width)) / 128 + (k == i % 3 ? 1 : 0);
    if (i % 7 == 0) cell.at[i % 3][random.below(cellVertices)] = NAN;

    embree::RayK<K> packet;
    VertRay rays[K];
    for (int r = 0; r < K; r++) {
      const unsigned a = random.below(cellVertices), b = random.below(cellVertices);
      float org[3], dir[3];
      for (int k = 0; k < 3; k++) {
        org[k] = float(random.below(64)) / 64 - (k == i % 3 ? 4 : 0);
        dir[k] =
            0.5f * (cell.at[k][a] + cell.at[k][b]) - org[k] + (random.chance(0.5) ? 0 : random.uniform(-0.01, 0.01));
      }
      const embree::Ray ray(Vec3fa(org[0], org[1], org[2]), Vec3fa(dir[0], dir[1], dir[2]), 0.0f, INFINITY);
      rays[r].set(ray);
      packet.set(r, ray);
    }
    VertRays<K> together;
    together.set(packet);
    for (uint32_t kz = 0; kz < 3; kz++) {
      const GroupTrianglesK<K> triangles(together, kz, cell);
      for (int r = 0; r < K; r++) {
        if (uint32_t(together.rayClass[r] & 3) != kz) continue;
        ASSERT_EQ(rays[r].kz, int(kz));
        const uint32_t mask = GroupTriangles(rays[r], cell).mask;
        ASSERT_EQ(uint32_t(triangles.mask[r]), mask) << "case " << i << ", ray " << r << " of " << K;
        ASSERT_EQ(GroupTriangles(together.ray(r), cell).mask, mask);
        found += mask != 0;
      }
    }
  }
  EXPECT_GT(found, 1000u);
}

TEST(VertTriangles, PacketsMatchSingleRays) {
  comparePacketsWithRays<4>();
#if defined(__AVX__)
  comparePacketsWithRays<8>();
#endif
#if defined(__AVX512F__)
  comparePacketsWithRays<16>();
#endif
}

// As seen by a thread with weakly ordered loads while another thread maps the first file: the function that checks
// blocks is not visible yet.
TEST(MappedBlocks, BlockIsUsableBeforeAnyFileIsVisible) {
  const uint64_t block[2] = {0, 0};
  ASSERT_EQ(mappedBlockValidator.load(), nullptr) << "this program has no files";
  EXPECT_TRUE(isBlockValid(block, VERT_BLOCK));
  mappedBytes = ~size_t(0);
  EXPECT_TRUE(isBlockValid(block, VERT_BLOCK));
  mappedBlockValidator = [](const void*, BlockType type) { return type != VERT_BLOCK; };
  EXPECT_FALSE(isBlockValid(block, VERT_BLOCK));
  EXPECT_TRUE(isBlockValid(block, MESH_BLOCK));
  mappedBytes = 0;
  EXPECT_TRUE(isBlockValid(block, VERT_BLOCK));
  mappedBlockValidator = nullptr;
}

}} // namespace programs::test
