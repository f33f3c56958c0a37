// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares the traversal's decoder of mesh blocks with the scalar one, cvert/decoder/decoded_mesh.h: random blocks, all
 * groups exactly, and boxes that contain the triangles. Compiled once for every ISA, outside of the library. */

#include "kernels/cvert/decoder/decoded_mesh.h"
#include "kernels/cvert/conversion/mesh_tile_conversion.h"
#include "kernels/cbvh/exact/decoded_mesh_tile.h"
#include "support/random.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

// for isa_check.cpp
extern const char* const programIsa;
const char* const programIsa = TEST_ISA;

namespace programs::test { namespace {

using namespace embree::cbvh;

// Triangles of neighbors in a wavy sheet, or of random vertices. exponent: of a lattice, or at most -1000 for none
std::vector<MeshTriangle> randomTriangles(Random& random, int exponent, double far, bool isSheet) {
  const uint32_t size = 16;
  float points[(size + 1) * (size + 1)][3];
  double axis[3][3], origin[3];
  for (int k = 0; k < 3; k++) {
    origin[k] = far * random.uniform(-1, 1);
    for (auto& a : axis) a[k] = random.uniform(-1, 1);
  }
  for (uint32_t i = 0; i < (size + 1) * (size + 1); i++)
    for (int k = 0; k < 3; k++) {
      const double u = i % (size + 1) + random.uniform(-0.3, 0.3), v = double(i / (size + 1));
      const double x = origin[k] + u * axis[0][k] + v * axis[1][k] + 0.1 * random.normal() * axis[2][k];
      points[i][k] = exponent > -1000 ? float(std::ldexp(std::floor(std::ldexp(x, -exponent)), exponent)) : float(x);
    }
  std::vector<MeshTriangle> triangles;
  for (uint32_t n = 1 + random.below(256), first = random.bits(); triangles.size() < n;) {
    uint32_t v[3];
    const uint32_t x = random.below(size), y = uint32_t(triangles.size()) / size;
    for (uint32_t& i : v)
      i = isSheet ? (y + random.below(2)) * (size + 1) + x + random.below(2) : random.below((size + 1) * (size + 1));
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    MeshTriangle t;
    for (int c = 0; c < 3; c++) std::copy_n(points[v[c]], 3, t.corners[c]);
    if (std::equal(t.corners[0], t.corners[1], t.corners[1]) || std::equal(t.corners[1], t.corners[2], t.corners[2]) ||
        std::equal(t.corners[2], t.corners[2] + 3, t.corners[0]))
      continue;
    t.number = random.chance(0.05) ? random.bits() : first + uint32_t(triangles.size());
    triangles.push_back(t);
  }
  return triangles;
}

TEST(MeshDecoding, GroupsMatchScalarDecoder) {
  Random random(96);
  auto encoder = std::make_unique<MeshEncoder>();
  std::vector<uint64_t> memory(MeshEncoder::maxBytes / 8 + 4);
  MeshStatistics statistics;
  for (int i = 0; i < 3000; i++) {
    const auto triangles = randomTriangles(random, i % 3 ? -int(random.below(14)) : -1001,
                                           std::vector<double>{0, 10, 1e4, 1e6}[random.below(4)], i % 4 != 0);
    std::vector<uint32_t> ends;
    const uint32_t count = uint32_t(triangles.size()), groupSize = std::vector<uint32_t>{3, 16, 32}[random.below(3)];
    for (uint32_t end = groupSize; ends.empty() || ends.back() < count; end += groupSize)
      ends.push_back(std::min(end, count));
    uint32_t stored;
    uint8_t* const bytes = (uint8_t*)memory.data();
    std::fill(memory.begin(), memory.end(), ~uint64_t(0));
    encoder->encode(triangles.data(), ends.data(), uint32_t(ends.size()), 3, bytes, stored, statistics);
    const MeshHeader* const block = (const MeshHeader*)bytes;
    const MeshView view(block);
    const embree::isa::cbvh::MeshDecoder decoder(block);
    auto entry = std::make_unique<MeshBlockEntry>();
    decoder.decode(*entry);
    ASSERT_EQ(entry->lanes, (1u << view.groups) - 1);
    for (uint32_t g = 0; g < view.groups; g++) {
      SCOPED_TRACE(testing::Message() << "block " << i << ", group " << g);
      const DecodedMeshGroup expected(view, g);
      MeshTriangles halves[2];
      decoder.triangles(*entry, g, 0, halves[0]);
      ASSERT_EQ(halves[0].hasNextHalf, expected.numTriangles > 16);
      if (halves[0].hasNextHalf) {
        decoder.triangles(*entry, g, 1, halves[1]);
        ASSERT_FALSE(halves[1].hasNextHalf);
        ASSERT_EQ(halves[1].lanes, 0xFFFFu >> (32 - expected.numTriangles));
      }
      ASSERT_EQ(halves[0].lanes, halves[0].hasNextHalf ? 0xFFFFu : 0xFFFFu >> (16 - expected.numTriangles));
      for (uint32_t t = 0; t < expected.numTriangles; t++) {
        ASSERT_EQ(decoder.number(*entry, g, t), expected.numbers[t]);
        for (int c = 0; c < 3; c++) {
          double sheared = 0;
          for (int k = 0; k < 3; k++) {
            const float x = expected.corners[c][k][t];
            const MeshTriangles& half = halves[t / 16];
            ASSERT_EQ(half.vertices.at[k][half.corners[c][t % 16]], x)
                << "triangle " << t << ", corner " << c << ", axis " << k;
            ASSERT_LE(std::fabs(double(x) - entry->origin[k]), entry->extent[k] * (1 + 1e-6));
            sheared += (double(x) - entry->origin[k]) * entry->shear[k];
            if (k == entry->shearedAxis) continue;
            ASSERT_LE(entry->planes[k].at[0][g], x);
            ASSERT_GE(entry->planes[k].at[1][g], x);
          }
          if (entry->shearedAxis == 3) continue;
          ASSERT_LE(entry->planes[entry->shearedAxis].at[0][g], sheared);
          ASSERT_GE(entry->planes[entry->shearedAxis].at[1][g], sheared);
        }
      }
    }
  }
  EXPECT_GT(statistics.rankAxes, 100u);
  EXPECT_GT(statistics.shearedBlocks, 100u);
  EXPECT_GT(statistics.restarts, 100u);
}

// Vertices, corners and numbers of mesh tiles, at all widths of fields.
TEST(MeshTileDecoding, GroupsMatchScalarDecoder) {
  using embree::isa::cbvh::DecodedMeshTile;
  Random random(98);
  auto encoder = std::make_unique<MeshEncoder>();
  std::vector<uint64_t> memory(MeshEncoder::maxBytes / 8 + 4),
      tileMemory((maxBytesOfMeshTile + meshTileReadPadding) / 8);
  MeshStatistics statistics;
  size_t tiles = 0, sheared = 0;
  for (int i = 0; i < 3000; i++) {
    const auto triangles = randomTriangles(random, -int(random.below(14)),
                                           std::vector<double>{0, 10, 1e4, 1e6}[random.below(4)], i % 4 != 0);
    std::vector<uint32_t> ends;
    const uint32_t count = uint32_t(triangles.size()), groupSize = std::vector<uint32_t>{3, 11, 16}[random.below(3)];
    for (uint32_t end = groupSize; ends.empty() || ends.back() < count; end += groupSize)
      ends.push_back(std::min(end, count));
    uint32_t stored;
    encoder->encode(triangles.data(), ends.data(), uint32_t(ends.size()), 3, (uint8_t*)memory.data(), stored,
                    statistics);
    std::fill(tileMemory.begin(), tileMemory.end(), ~uint64_t(0));
    if (tileOfMesh((const MeshHeader*)memory.data(), (uint8_t*)tileMemory.data()) == 0) continue;
    tiles++;
    const MeshTileHeader* const header = (const MeshTileHeader*)tileMemory.data();
    const MeshTileView view(header);
    const DecodedMeshTile decoded(header);
    const GroupBoxes& boxes = decoded.boxes();
    ASSERT_EQ(boxes.lanes, (1u << view.groups) - 1);
    sheared += boxes.shearedAxis != 3;
    for (uint32_t g = 0; g < view.groups; g++) {
      SCOPED_TRACE(testing::Message() << "tile " << i << ", group " << g);
      const MeshTriangles& group = decoded.triangles(g, 0);
      ASSERT_EQ(group.lanes, 0xFFFFu >> (16 - view.triangles(g)));
      for (uint32_t t = 0; t < view.triangles(g); t++) {
        ASSERT_EQ(decoded.point(g, t, 0.25f, 0.5f).primID, view.number(g, t));
        for (uint32_t c = 0; c < 3; c++) {
          ASSERT_EQ(group.corners[c][t], view.corner(g, t, c));
          float p[3];
          view.vertex(g, view.corner(g, t, c), p);
          double along = 0;
          for (uint32_t k = 0; k < 3; k++) {
            ASSERT_EQ(group.vertices.at[k][group.corners[c][t]], p[k]);
            along += (double(p[k]) - boxes.origin[k]) * boxes.shear[k];
            ASSERT_LE(std::fabs(double(p[k]) - boxes.origin[k]), boxes.extent[k] * (1 + 1e-6));
            if (int(k) == boxes.shearedAxis) continue;
            ASSERT_LE(boxes.planes[k].at[0][g], p[k]);
            ASSERT_GE(boxes.planes[k].at[1][g], p[k]);
          }
          if (boxes.shearedAxis == 3) continue;
          ASSERT_LE(boxes.planes[boxes.shearedAxis].at[0][g], along);
          ASSERT_GE(boxes.planes[boxes.shearedAxis].at[1][g], along);
        }
      }
    }
  }
  EXPECT_GT(tiles, 1000u);
  EXPECT_GT(sheared, 100u);
}

// Triangles of random vertices, and rays through a vertex or the middle of two: triangles that contain the ray must
// be found. The stored sides must equal those that each triangle computes.
TEST(MeshTriangles, TrianglesThatContainTheRayAreFound) {
  using namespace embree::isa::cbvh;
  using embree::Vec3fa;
  Random random(97);
  size_t found = 0, onEdges = 0;
  for (int i = 0; i < 8000; i++) {
    MeshTriangles group;
    std::memset((void*)&group, random.below(256), sizeof(group));
    float vertices[32][3];
    const uint32_t numVertices = 3 + random.below(29), count = 1 + random.below(16);
    group.lanes = 0xFFFFu >> (16 - count);
    group.numVertices = uint8_t(numVertices);
    for (auto& corners : group.corners)
      for (uint8_t& v : corners) v &= 31;
    for (uint32_t v = 0; v < numVertices; v++)
      for (float& x : vertices[v]) x = float(random.below(i % 2 ? 9 : 4096)) / 128;
    for (uint32_t t = 0; t < count; t++)
      for (int c = 0; c < 3; c++) {
        const uint32_t v = random.below(numVertices);
        group.corners[c][t] = uint8_t(v);
        for (int k = 0; k < 3; k++) group.vertices.at[k][v] = vertices[v][k];
      }
    const uint32_t a = random.below(numVertices), b = random.below(numVertices);
    float org[3], dir[3];
    for (int k = 0; k < 3; k++) {
      org[k] = float(random.below(64)) / 64 - (k == 2 ? 4 : 0);
      dir[k] = 0.5f * (vertices[a][k] + vertices[b][k]) - org[k];
    }
    VertRay ray;
    ray.set(embree::Ray(Vec3fa(org[0], org[1], org[2]), Vec3fa(dir[0], dir[1], dir[2]), 0.0f, INFINITY));
    SidesInLanes stored;
    const uint32_t mask = trianglesHitByLine(ray, group, stored);
    ASSERT_EQ(mask & ~group.lanes, 0u);
    for (uint32_t t = 0; t < count; t++) {
      const VertTriangle triangle = triangleInLane(group, t);
      const VertTriangle::Sides sides = triangle.sides(ray);
      ASSERT_TRUE(stored.at(t).w0 == sides.w0 && stored.at(t).w1 == sides.w1 && stored.at(t).w2 == sides.w2)
          << "case " << i << ", triangle " << t;
      const bool isInside = triangle.containsExactly(ray), isCertain = haveExactSigns(sides);
      if (isInside) {
        ASSERT_TRUE(mask >> t & 1) << "case " << i << ", triangle " << t;
      } else {
        ASSERT_FALSE((mask >> t & 1) && isCertain) << "case " << i << ", triangle " << t;
      }
      found += isInside;
      onEdges += isInside && !isCertain;
    }
  }
  EXPECT_GT(found, 5000u);
  EXPECT_GT(onEdges, 50u);
}

}} // namespace programs::test
