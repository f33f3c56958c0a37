// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Clusters for GPUs, without the library: conversion of floats to integers, limits of the formats, strips with gaps,
 * and the bytes of an annotated block. */

#include "support/cluster_decoder.h"
#include "support/random.h"

#include "kernels/cvert/clusters/compressed1.h"
#include "kernels/cvert/clusters/dgf_tiling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>

using namespace cvert;

namespace programs::test { namespace {

typedef std::array<float, 3> Vertex;

struct Grid {
  unsigned width, height; // in vertices
  std::vector<Vertex> vertices;

  Grid(unsigned quadsX, unsigned quadsY) : width(quadsX + 1), height(quadsY + 1), vertices(width * height) {}
  Vertex& at(unsigned x, unsigned y) { return vertices[y * width + x]; }
  const float* points() const { return vertices[0].data(); }

  // Multiples of 2^exponent from `first` on, with noise of some bits.
  void fill(Random& random, int exponent, int first, unsigned bits) {
    for (Vertex& v : vertices)
      for (float& x : v) x = std::ldexp(float(first + int(random.below(1u << bits))), exponent);
  }
};

bool place(const Grid& grid, LatticePoints& points) {
  return points.set(grid.points(), grid.width, grid.width, grid.height);
}

TEST(ClusterCodec, PointsAreFloatsDividedByPowerOfTwo) {
  Random random(181);
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  for (int round = 0; round < 2000; round++) {
    Grid grid(1 + random.below(16), 1 + random.below(16));
    const int exponent = int(random.below(232)) - 126;
    grid.fill(random, exponent, int(random.below(1u << 23)) - (1 << 22), random.below(17));
    ASSERT_TRUE(place(grid, *points));
    ASSERT_GE(int(points->exponent) - 127, std::min(exponent, 105));
    bool anyOdd = points->exponent == 232;
    for (unsigned i = 0; i < grid.vertices.size(); i++)
      for (int k = 0; k < 3; k++) {
        ASSERT_EQ(std::ldexp(float(points->at[i][k]), int(points->exponent) - 127), grid.vertices[i][k]);
        anyOdd |= (points->at[i][k] & 1) != 0;
      }
    ASSERT_TRUE(anyOdd) << "a coarser lattice would suffice";
  }
}

TEST(ClusterCodec, RejectsVerticesOutsideOfFormat) {
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  const auto fits = [&](float a, float b) {
    Grid grid(1, 1);
    grid.at(0, 0) = {a, 0, 0};
    grid.at(1, 0) = {b, 0, 0};
    if (!place(grid, *points)) return false;
    LatticeSpan span;
    span.add(points->at[0]);
    span.add(points->at[1]);
    return span.fits();
  };
  EXPECT_TRUE(fits(8388607, 8388606));
  EXPECT_TRUE(fits(-8388608, -8388607));
  EXPECT_TRUE(fits(8388607, 8388609)) << "an offset is added to the anchor";
  EXPECT_FALSE(fits(8388611, 8388609)) << "beyond 2^23 steps";
  EXPECT_FALSE(fits(-8388609, -8388608));
  EXPECT_FALSE(fits(1, 16777216)) << "wider than an offset";
  EXPECT_TRUE(fits(1, 65536));
  EXPECT_FALSE(fits(0, 65537));
  EXPECT_FALSE(fits(1, 1e-8f)) << "no common lattice";
  EXPECT_TRUE(fits(std::ldexp(1.0f, -126), std::ldexp(3.0f, -126)));
  EXPECT_FALSE(fits(std::ldexp(1.0f, -127), 0)) << "below 2^-126";
  EXPECT_TRUE(fits(std::ldexp(1.0f, 127), std::ldexp(127.0f, 120))) << "above 2^105 spacings are multiples of 2^105";
  EXPECT_TRUE(fits(0.0f, -0.0f));
}

// Vertices on a lattice are the same floats after encoding and decoding as COMPRESSED1.
void expectVerticesBack(const Grid& grid, const QuadTriangles& triangles, const LatticePoints& points) {
  LatticeSpan span;
  for (unsigned i = 0; i < triangles.numVertices; i++) span.add(points.at[triangles.vertices[i]]);
  ASSERT_TRUE(span.fits());
  std::vector<uint32_t> data(maxCompressed1Bytes(81) / 4 + 1);
  const size_t bytes = writeCompressed1(points, span, triangles.vertices, triangles.numVertices, (uint8_t*)data.data());
  const DecodedCluster decoded = decodeCompressed1(data.data(), bytes, triangles.numVertices);
  for (unsigned i = 0; i < triangles.numVertices; i++)
    ASSERT_EQ(decoded.vertices[i], grid.vertices[triangles.vertices[i]]);
}

TEST(ClusterCodec, Compressed1RoundTripsVertices) {
  Random random(182);
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  for (int round = 0; round < 1000; round++) {
    Grid grid(1 + random.below(8), 1 + random.below(8));
    grid.fill(random, int(random.below(100)) - 50, int(random.below(1u << 24)) - (1 << 23), random.below(17));
    const QuadRectangle all = {0, 0, grid.width - 1, grid.height - 1};
    const QuadTriangles triangles(grid.points(), grid.width, all, false);
    if (triangles.numVertices == 0) continue;
    ASSERT_TRUE(place(grid, *points));
    expectVerticesBack(grid, triangles, *points);
  }
}

// The largest float, almost 2^128, is 8,388,607 spacings of 2^105, plus half a spacing.
TEST(ClusterCodec, LargestFloatsStayFinite) {
  Random random(183);
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  for (int sign : {1, -1}) {
    Grid grid(4, 4);
    for (Vertex& v : grid.vertices)
      for (float& x : v) x = std::ldexp(float(sign * (8388607 - int(random.below(65535)))), 105);
    grid.at(0, 0)[0] = std::ldexp(float(sign * 8388607), 105);
    const QuadTriangles triangles(grid.points(), grid.width, {0, 0, 4, 4}, false);
    ASSERT_TRUE(place(grid, *points));
    ASSERT_EQ(points->exponent, 232u);
    expectVerticesBack(grid, triangles, *points);
  }
  Grid grid(1, 1);
  grid.at(0, 0)[0] = std::ldexp(16777215.0f, 104);
  EXPECT_FALSE(place(grid, *points)) << "half spacings require a finer lattice, where they exceed 2^23 spacings";
}

typedef std::array<Vertex, 3> Triangle;

Triangle turned(const Triangle& t) { return std::min({t, Triangle{t[1], t[2], t[0]}, Triangle{t[2], t[0], t[1]}}); }

// Triangles without a missing vertex that are not degenerate.
std::multiset<Triangle> trianglesOf(Grid& grid) {
  std::multiset<Triangle> all;
  const auto add = [&](const Vertex& a, const Vertex& b, const Vertex& c) {
    for (const Vertex& v : {a, b, c})
      if (!std::isfinite(v[0])) return;
    if (a != b && b != c && c != a) all.insert(turned({a, b, c}));
  };
  for (unsigned y = 0; y + 1 < grid.height; y++)
    for (unsigned x = 0; x + 1 < grid.width; x++) {
      add(grid.at(x, y), grid.at(x + 1, y), grid.at(x, y + 1));
      add(grid.at(x, y + 1), grid.at(x + 1, y), grid.at(x + 1, y + 1));
    }
  return all;
}

TEST(ClusterCodec, DgfRoundTripsTrianglesOfGridsWithGaps) {
  Random random(183);
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  std::unique_ptr<dgf::Block> block(new dgf::Block);
  size_t written = 0, refused = 0;
  for (int round = 0; round < 20000; round++) {
    Grid grid(1 + random.below(8), 1 + random.below(8));
    grid.fill(random, -3, int(random.below(1u << 24)) - (1 << 23), random.below(13));
    const double missing = random.chance(0.5) ? 0 : random.uniform(0, 0.5);
    for (unsigned y = 0; y < grid.height; y++)
      for (unsigned x = 0; x < grid.width; x++) {
        if (random.chance(missing)) grid.at(x, y)[0] = NAN;
        else if (x > 0 && random.chance(0.3 * missing)) grid.at(x, y) = grid.at(x - 1, y); // stitched
      }
    const QuadRectangle all = {0, 0, grid.width - 1, grid.height - 1};
    const QuadTriangles triangles(grid.points(), grid.width, all, true);
    ASSERT_TRUE(place(grid, *points));
    const std::multiset<Triangle> expected = trianglesOf(grid);
    ASSERT_EQ(triangles.numTriangles, expected.size());
    if (expected.empty()) continue;
    const unsigned primitives = random.below(1u << 29) - 64;
    if (!block->write(triangles, *points, primitives & 0x1FFFFFFF)) {
      refused++;
      ASSERT_GT(triangles.numTriangles, 2u) << "a quad fits";
      continue;
    }
    written++;
    const DecodedCluster decoded = decodeDgf(block->bytes, sizeof(block->bytes));
    ASSERT_EQ(decoded.primitives, primitives & 0x1FFFFFFF);
    std::multiset<Triangle> found;
    for (const auto& t : decoded.triangles)
      found.insert(turned({decoded.vertices[t[0]], decoded.vertices[t[1]], decoded.vertices[t[2]]}));
    ASSERT_EQ(found, expected);
  }
  EXPECT_GT(written, 5000u);
  EXPECT_GT(refused, 100u);
}

// Bits per index of the strip of a whole grid, in a block with small offsets. 6 if it does not fit even then.
unsigned bitsPerIndex(unsigned quadsX, unsigned quadsY) {
  Grid grid(quadsX, quadsY);
  for (unsigned i = 0; i < grid.vertices.size(); i++)
    grid.vertices[i] = {float(i % grid.width), float(i / grid.width), 0};
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  std::unique_ptr<dgf::Block> block(new dgf::Block);
  if (!place(grid, *points) ||
      !block->write(QuadTriangles(grid.points(), grid.width, {0, 0, quadsX, quadsY}, true), *points, 0))
    return 6;
  return decodeDgf(block->bytes, sizeof(block->bytes)).bitsPerIndex;
}

// True if one strip of all quads, which visits each inner vertex twice, fits into a block.
bool hasRoom(Grid& grid, int exponent, unsigned bitsPerIndex) {
  const unsigned vertices = grid.width * grid.height, triangles = 2 * (grid.width - 1) * (grid.height - 1),
                 reused = (grid.width - 2) * (grid.height - 2);
  unsigned bits = 0;
  for (int k = 0; k < 3; k++) {
    const auto extent = std::minmax_element(grid.vertices.begin(), grid.vertices.end(),
                                            [&](const Vertex& a, const Vertex& b) { return a[k] < b[k]; });
    const unsigned steps = unsigned(std::ldexp(double((*extent.second)[k]) - (*extent.first)[k], -exponent));
    unsigned b = 1;
    while (steps >> b) b++;
    bits += b;
  }
  bits = (bits + 3) / 4 * 4;
  const unsigned front = (vertices * bits + 7) / 8;
  return vertices <= 64 && triangles <= 64 && front <= 96 &&
         8 * (20 + front) + reused * bitsPerIndex + (triangles - 1) + 2 * (triangles - 1) <= 8 * 128;
}

TEST(ClusterCodec, WholeGridIsOneStripOfMinimalSize) {
  Random random(185);
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  std::unique_ptr<dgf::Block> block(new dgf::Block);
  size_t written = 0, refused = 0;
  for (int round = 0; round < 5000; round++) {
    Grid grid(1 + random.below(8), 1 + random.below(8));
    grid.fill(random, 0, 1 << 20, 4 + random.below(12));
    const QuadTriangles triangles(grid.points(), grid.width, {0, 0, grid.width - 1, grid.height - 1}, true);
    ASSERT_TRUE(place(grid, *points));
    if (!triangles.isComplete || points->exponent != 127) continue;
    const bool hasRoom = test::hasRoom(grid, 0, bitsPerIndex(grid.width - 1, grid.height - 1));
    if (!block->write(triangles, *points, 0)) {
      refused++;
      ASSERT_FALSE(hasRoom) << grid.width << " x " << grid.height;
      continue;
    }
    written++;
    ASSERT_TRUE(hasRoom);
    const DecodedCluster decoded = decodeDgf(block->bytes, sizeof(block->bytes));
    ASSERT_EQ(decoded.numIndices, triangles.numTriangles + 2u);
  }
  EXPECT_GT(written, 1000u);
  EXPECT_GT(refused, 500u);
}

TEST(ClusterCodec, DgfRefusesTrianglesThatAreTooLarge) {
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  std::unique_ptr<dgf::Block> block(new dgf::Block);
  Grid grid(1, 1);
  for (float size : {65535.0f, 65537.0f}) { // 16 and 17 bits per axis
    grid.vertices = {{0, 0, 0}, {size, 0, size}, {0, size, 0}, {size, size, size}};
    ASSERT_TRUE(place(grid, *points));
    EXPECT_EQ(block->write(QuadTriangles(grid.points(), grid.width, {0, 0, 1, 1}, true), *points, 0), size < 65536);
  }
}

TEST(ClusterCodec, TrianglesReportTheirIndexInPart) {
  Random random(186);
  for (int round = 0; round < 500; round++) {
    Grid grid(9 + random.below(20), 9 + random.below(20));
    grid.fill(random, 0, 5, 10);
    const uint32_t width = 1 + random.below(8), height = 1 + random.below(8);
    const QuadRectangle of = {random.below(grid.width - width), random.below(grid.height - height), width, height};
    for (bool isStrip : {false, true}) {
      const QuadTriangles triangles(grid.points(), grid.width, of, isStrip);
      std::set<uint32_t> seen;
      for (uint32_t t = 0; t < triangles.numTriangles; t++) {
        const uint32_t id = triangles.triangles[t], x = id / 2 % (grid.width - 1), y = id / 2 / (grid.width - 1);
        ASSERT_TRUE(seen.insert(id).second);
        ASSERT_TRUE(x >= of.x && x < of.x + width && y >= of.y && y < of.y + height);
        const Triangle expected = id % 2 ? Triangle{grid.at(x, y + 1), grid.at(x + 1, y), grid.at(x + 1, y + 1)}
                                         : Triangle{grid.at(x, y), grid.at(x + 1, y), grid.at(x, y + 1)};
        for (int c = 0; c < 3; c++) {
          const uint32_t v = triangles.vertices[triangles.indices[t][c]];
          ASSERT_EQ(grid.at(of.x + v % (width + 1), of.y + v / (width + 1)), expected[c]);
        }
      }
    }
  }
}

TEST(ClusterCodec, TilesCoverEachQuadOnceAndFit) {
  Random random(184);
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  std::unique_ptr<dgf::Block> block(new dgf::Block);
  for (int round = 0; round < 300; round++) {
    Grid grid(1 + random.below(16), 1 + random.below(16));
    grid.fill(random, 2, -12345, random.below(17));
    const bool hasGaps = random.chance(0.2);
    if (hasGaps)
      for (Vertex& v : grid.vertices) v[2] = random.chance(0.9) ? NAN : v[2]; // many quads without triangles
    ASSERT_TRUE(place(grid, *points));
    const dgf::Tiling tiling(*points, grid.width - 1, grid.height - 1);
    ASSERT_TRUE(tiling.isPossible);
    std::vector<unsigned> covered((grid.width - 1) * (grid.height - 1));
    tiling.forEach([&](uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
      for (uint32_t j = 0; j < height; j++)
        for (uint32_t i = 0; i < width; i++) covered.at((y + j) * (grid.width - 1) + x + i)++;
      ASSERT_LE((width + 1) * (height + 1), 64u);
      QuadTriangles triangles(grid.points(), grid.width, {x, y, width, height}, true);
      if (hasGaps || !triangles.isComplete) return;
      for (uint32_t i = 0; i < triangles.numVertices; i++)
        triangles.vertices[i] =
            (y + triangles.vertices[i] / (width + 1)) * grid.width + x + triangles.vertices[i] % (width + 1);
      ASSERT_TRUE(block->write(triangles, *points, 0)) << width << " x " << height;
    });
    ASSERT_EQ(std::count(covered.begin(), covered.end(), 1u), long(covered.size()));
  }
}

// Two adjacent quads, whose bytes annotated_blocks.txt lists.
TEST(ClusterCodec, BytesMatchAnnotatedClusters) {
  Grid grid(2, 1);
  for (unsigned y = 0; y < 2; y++)
    for (unsigned x = 0; x < 3; x++) grid.at(x, y) = {100.0f + 8.0f * float(x), 16.0f * float(y), float(x * x) - 3.0f};
  std::unique_ptr<LatticePoints> points(new LatticePoints);
  ASSERT_TRUE(place(grid, *points));
  const QuadRectangle all = {0, 0, 2, 1};
  const QuadTriangles rows(grid.points(), grid.width, all, false);
  LatticeSpan span;
  for (unsigned i = 0; i < rows.numVertices; i++) span.add(points->at[rows.vertices[i]]);
  std::vector<uint32_t> data(maxCompressed1Bytes(81) / 4 + 1);
  const size_t bytes = writeCompressed1(*points, span, rows.vertices, rows.numVertices, (uint8_t*)data.data());
  std::string text;
  const auto print = [&](const uint8_t* from, size_t count) {
    char hex[4];
    text.clear();
    for (size_t i = 0; i < count; i++) {
      std::snprintf(hex, sizeof(hex), "%02x", from[i]);
      text += (i ? " " : "") + std::string(hex);
    }
  };
  std::ifstream file(FORMATS "/../../tests/codec/annotated_blocks.txt");
  const std::string document((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  print((const uint8_t*)data.data(), bytes);
  for (size_t i = 0; i < text.size(); i += 48) EXPECT_NE(document.find(text.substr(i, 47)), std::string::npos) << text;
  const QuadTriangles strip(grid.points(), grid.width, all, true);
  dgf::Block block;
  ASSERT_TRUE(block.write(strip, *points, 42));
  print(block.bytes, 128);
  EXPECT_NE(document.find(text.substr(0, 47)), std::string::npos) << text;
  EXPECT_NE(document.find(text.substr(48, 47)), std::string::npos) << text;
  EXPECT_NE(document.find(text.substr(text.size() - 5)), std::string::npos) << text;
}

}} // namespace programs::test
