// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cVERT blocks of all sizes are lossless, and boxes contain their groups in the float arithmetic of traversal. */

#include "kernels/cvert/encoder/lattice.h"
#include "kernels/cvert/encoder/block_encoder.h"
#include "kernels/cvert/decoder/decoded_block.h"
#include "kernels/cvert/decoder/validate.h"
#include "codec/format_pages.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <vector>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t seed = 71;

// Memory for a block. The encoder must not write after it.
struct Encoded {
  alignas(16) uint8_t bytes[VertEncoder::maxBytes];
  size_t size = 0;
  VertStatistics statistics;

  Encoded(VertEncoder& encoder, const VertPlacement& at) { size = encoder.encode(at, bytes, statistics); }
  const VertHeader* block() const { return (const VertHeader*)bytes; }
};

VertPlacement whole(uint32_t quadsX, uint32_t quadsY) {
  return {packRegion(quadsX, quadsY, 0, 0), packPatchQuads(quadsX, quadsY)};
}

// The same with edges after its header.
VertPlacement withEdges(uint32_t quadsX, uint32_t quadsY) {
  return {packRegion(quadsX, quadsY, 0, 0), packPatchQuads(quadsX, quadsY), packEdges(quadsX, quadsY, 1, 1, 1, 5)};
}

// Vertices on a lattice: a plane, a bend and noise in spacings.
struct Sheet {
  uint32_t quadsX, quadsY;
  float spacing;
  double origin[3];
  std::vector<std::array<float, 3>> vertices;

  Sheet(Random& random, uint32_t quadsX, uint32_t quadsY, double roughness) : quadsX(quadsX), quadsY(quadsY) {
    spacing = std::ldexp(1.0f, int(random.below(60)) - 30);
    double axis[3][3];
    for (int k = 0; k < 3; k++) {
      origin[k] = std::floor(random.uniform(-4e6, 4e6));
      for (double* a : {axis[0], axis[1], axis[2]}) a[k] = random.uniform(-40, 40);
    }
    for (uint32_t y = 0; y <= quadsY; y++)
      for (uint32_t x = 0; x <= quadsX; x++) {
        const double h = roughness * random.normal() + 0.02 * (double(x) * x - double(y) * x);
        std::array<float, 3> v;
        // with a roughness of 40, residuals are large on all axes
        const double sideways = roughness == 40 ? 1000 : 0;
        for (int k = 0; k < 3; k++)
          v[k] = float((origin[k] + std::floor(x * axis[0][k] + y * axis[1][k] +
                                               (sideways > 0 ? sideways * random.normal() : h * axis[2][k]))) *
                       spacing);
        vertices.push_back(v);
      }
  }

  void fill(VertEncoder& encoder) const {
    for (size_t i = 0; i < vertices.size(); i++) std::copy(vertices[i].begin(), vertices[i].end(), encoder.vertices[i]);
  }
};

// Relative to the block's origin; exact.
float shearedCoordinate(const VertHeader* block, const float* p) {
  const int m = shearedAxis(block->info), a = (m + 1) % 3, b = (m + 2) % 3;
  return float(double(p[m]) - block->origin[m] + shearSlope(block->info, 1) / 16.0 * (double(p[a]) - block->origin[a]) +
               shearSlope(block->info, 2) / 16.0 * (double(p[b]) - block->origin[b]));
}

float spacingOf(const VertHeader* block, int axis) { return vertSpacing(block->word, block->corners).at[axis]; }

bool sameFloat(float a, float b) { return std::memcmp(&a, &b, sizeof(a)) == 0 || (a == 0 && b == 0); }

TEST(VertBlock, VerticesRoundTrip) {
  Random random(seed);
  auto encoder = std::make_unique<VertEncoder>();
  size_t packed = 0, raw = 0, byAxis = 0;
  for (int i = 0; i < 4000; i++) {
    const Sheet sheet(random, 1 + random.below(16), 1 + random.below(16),
                      std::vector<double>{0, 0.05, 0.5, 5, 40}[i % 5]);
    sheet.fill(*encoder);
    const Encoded encoded(*encoder,
                          i % 4 == 0 ? withEdges(sheet.quadsX, sheet.quadsY) : whole(sheet.quadsX, sheet.quadsY));
    ASSERT_GT(encoded.size, sizeof(VertHeader));
    const auto decoded = std::make_unique<DecodedBlock>(encoded.block());
    ASSERT_EQ(decoded->quadsX, sheet.quadsX);
    ASSERT_EQ(decoded->quadsY, sheet.quadsY);
    for (size_t v = 0; v < sheet.vertices.size(); v++)
      for (int k = 0; k < 3; k++)
        ASSERT_TRUE(sameFloat(decoded->vertices[v][k], sheet.vertices[v][k]))
            << "sheet " << i << ", vertex " << v << ", axis " << k;
    ASSERT_EQ(encoded.statistics.raw, isRaw(encoded.block()->info));
    (encoded.statistics.raw ? raw : packed)++;
    byAxis += !encoded.statistics.raw && isByAxis(encoded.block()->word);
    ASSERT_EQ((vertBytes(encoded.block()) + 3) & ~3u, encoded.size);
    if (!encoded.statistics.raw) {
      ASSERT_EQ((size_t(decoded->end - encoded.bytes) + 3) & ~size_t(3), encoded.size) << "unused bytes";
    }
  }
  EXPECT_GT(packed, 3000u);
  EXPECT_GT(raw, 0u);
  EXPECT_GT(byAxis, 300u);
}

TEST(VertBlock, FlatPartHasNoFields) {
  auto encoder = std::make_unique<VertEncoder>();
  for (uint32_t y = 0; y <= 16; y++)
    for (uint32_t x = 0; x <= 16; x++) {
      float* v = encoder->vertices[17 * y + x];
      v[0] = 32.0f * float(x);
      v[1] = 32.0f * float(y);
      v[2] = 16.0f * float(x) - 48.0f * float(y);
    }
  const Encoded encoded(*encoder, whole(16, 16));
  EXPECT_EQ(encoded.statistics.fieldBytes, 0u);
  EXPECT_EQ(encoded.size, vertLayout(encoded.block()->region, encoded.block()->info).cell);
}

TEST(VertBlock, BoxesContainTheirGroups) {
  Random random(seed + 1);
  auto encoder = std::make_unique<VertEncoder>();
  size_t loose = 0, planes = 0, sheared = 0;
  for (int i = 0; i < 2000; i++) {
    const Sheet sheet(random, 1 + random.below(16), 1 + random.below(16), 0.5);
    sheet.fill(*encoder);
    const bool hole = i % 5 == 0;
    if (hole) encoder->vertices[0][i % 3] = i % 2 ? NAN : INFINITY;
    const VertPlacement place = i % 4 == 0 ? withEdges(sheet.quadsX, sheet.quadsY) : whole(sheet.quadsX, sheet.quadsY);
    const Encoded encoded(*encoder, place);
    const VertLayout layout = vertLayout(place.region, place.info());
    const auto decoded = std::make_unique<DecodedBlock>(encoded.block());
    for (uint32_t g = 0; g < layout.groups; g++) {
      float lower[3], upper[3];
      decoded->groupBox(g, lower, upper);
      const uint32_t x0 = groupQuads * (g % layout.groupsX), y0 = groupQuads * (g / layout.groupsX);
      for (int k = 0; k < 3; k++) {
        const bool isSheared = !encoded.statistics.raw && k == shearedAxis(encoded.block()->info);
        if (isSheared) sheared += shearSlope(encoded.block()->info, 1) != 0;
        float least = INFINITY, greatest = -INFINITY;
        for (uint32_t y = y0; y <= std::min(y0 + groupQuads, sheet.quadsY); y++)
          for (uint32_t x = x0; x <= std::min(x0 + groupQuads, sheet.quadsX); x++) {
            if (hole && x + y == 0) continue;
            const float v =
                isSheared ? shearedCoordinate(encoded.block(), decoded->vertex(x, y)) : decoded->vertex(x, y)[k];
            ASSERT_LE(lower[k], v) << "sheet " << i << ", group " << g;
            ASSERT_GE(upper[k], v) << "sheet " << i << ", group " << g;
            least = std::min(least, v);
            greatest = std::max(greatest, v);
          }
        if (encoded.statistics.raw) { // must be exact
          ASSERT_EQ(lower[k], least) << "sheet " << i << ", group " << g;
          ASSERT_EQ(upper[k], greatest) << "sheet " << i << ", group " << g;
          continue;
        }
        const float spacing = spacingOf(encoded.block(), k),
                    step = spacing * float(1u << marginShift(encoded.block()->info, k));
        planes += 2;
        // margins are whole coordinates; sheared ones are multiples of a sixteenth
        const float most = isSheared ? step + spacing : step;
        loose += (least - lower[k] >= most) + (upper[k] - greatest >= most);
      }
    }
  }
  EXPECT_EQ(loose, 0u) << "of " << planes << " planes are off by more than a step";
  EXPECT_GT(sheared, 1000u);
}

TEST(VertBlock, BoundsContainTheBlock) {
  Random random(seed + 3);
  auto encoder = std::make_unique<VertEncoder>();
  size_t blocks = 0, loose = 0;
  for (int i = 0; i < 2000; i++) {
    const Sheet sheet(random, 1 + random.below(16), 1 + random.below(16), std::vector<double>{0, 0.05, 0.5, 5}[i % 4]);
    sheet.fill(*encoder);
    const Encoded encoded(*encoder, whole(sheet.quadsX, sheet.quadsY));
    if (encoded.statistics.raw) continue;
    blocks++;
    const VertHeader* block = encoded.block();
    const auto decoded = std::make_unique<DecodedBlock>(block);
    const int m = shearedAxis(block->info);
    auto stepOn = [&](int k) { return float(boundsUnit(block->info)) * spacingOf(block, k); };
    float least[3] = {INFINITY, INFINITY, INFINITY}, greatest[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t v = 0; v < (sheet.quadsX + 1) * (sheet.quadsY + 1); v++) {
      const float* p = decoded->vertices[v];
      const float x[3] = {p[(m + 1) % 3] - block->origin[(m + 1) % 3], p[(m + 2) % 3] - block->origin[(m + 2) % 3],
                          shearedCoordinate(block, p)};
      for (int k = 0; k < 3; k++) {
        least[k] = std::min(least[k], x[k]);
        greatest[k] = std::max(greatest[k], x[k]);
      }
    }
    ASSERT_EQ(least[0], 0);
    ASSERT_EQ(least[1], 0);
    for (int k = 0; k < 3; k++) {
      const float step = stepOn(k < 2 ? (m + 1 + k) % 3 : m);
      const float upper = float(encodedBound(block->bounds, k < 2 ? k : 3)) * step,
                  lower = k < 2 ? 0 : float(encodedBound(block->bounds, 2)) * step;
      ASSERT_LE(lower, least[k]);
      ASSERT_GE(upper, greatest[k]);
      // sheared coordinates are multiples of a sixteenth
      loose += upper - greatest[k] > 1.0625f * step || least[k] - lower > 1.0625f * step;
    }
  }
  EXPECT_GT(blocks, 1000u);
  EXPECT_EQ(loose, 0u);
}

TEST(VertBlock, NonFiniteVerticesAreRawAndNaN) {
  Random random(seed + 2);
  auto encoder = std::make_unique<VertEncoder>();
  const Sheet sheet(random, 16, 16, 0.5);
  for (float bad : {NAN, INFINITY, -INFINITY, 3e18f})
    for (int axis = 0; axis < 3; axis++) {
      sheet.fill(*encoder);
      encoder->vertices[17 * 5 + 5][axis] = bad;
      const Encoded encoded(*encoder, whole(16, 16));
      EXPECT_TRUE(encoded.statistics.raw);
      EXPECT_EQ(encoded.statistics.invalidQuads, 4u);
      const auto decoded = std::make_unique<DecodedBlock>(encoded.block());
      for (int k = 0; k < 3; k++) {
        EXPECT_TRUE(std::isnan(decoded->vertex(5, 5)[k]));
        EXPECT_EQ(decoded->vertex(6, 5)[k], sheet.vertices[17 * 5 + 6][k]);
        float least = INFINITY;
        for (size_t v = 0; v < 17 * 17; v++)
          if (v != 17 * 5 + 5) least = std::min(least, sheet.vertices[v][k]);
        EXPECT_EQ(encoded.block()->origin[k], least) << bad << " on axis " << axis;
      }
    }
  for (auto& v : encoder->vertices) v[0] = NAN;
  EXPECT_EQ(Encoded(*encoder, whole(16, 16)).size, 0u) << "a block without valid vertices";
}

// Floats that are not on a lattice: at any position, of any size, with different units per axis, smooth or rough.
void fillWithFloats(Random& random, VertEncoder& encoder, uint32_t quadsX, uint32_t quadsY, int i) {
  double unit[3], place[3], axis[2][3];
  for (int k = 0; k < 3; k++) {
    unit[k] = std::ldexp(random.uniform(1, 2), int(random.below(60)) - 30);
    if (i % 3 && k > 0) unit[k] = unit[0];
    place[k] = std::vector<double>{0, 0, 3, 1000, 1e6}[random.below(5)] * random.uniform(-1, 1);
    for (auto& a : axis) a[k] = random.uniform(-0.06, 0.06);
  }
  const double roughness = std::vector<double>{0, 1e-4, 0.01, 0.3}[i % 4];
  for (uint32_t y = 0; y <= quadsY; y++)
    for (uint32_t x = 0; x <= quadsX; x++)
      for (int k = 0; k < 3; k++)
        encoder.vertices[y * (quadsX + 1) + x][k] =
            float(unit[k] * (place[k] + x * axis[0][k] + y * axis[1][k] + 1e-3 * (double(x) * x - y * x) +
                             roughness * random.normal()));
}

TEST(VertBlock, AnyFloatsRoundTrip) {
  Random random(seed + 3);
  auto encoder = std::make_unique<VertEncoder>();
  size_t raw = 0, withRemainders = 0, sheared = 0;
  for (int i = 0; i < 4000; i++) {
    const uint32_t quadsX = 1 + random.below(16), quadsY = 1 + random.below(16);
    fillWithFloats(random, *encoder, quadsX, quadsY, i);
    std::vector<std::array<float, 3>> given;
    for (uint32_t v = 0; v < (quadsX + 1) * (quadsY + 1); v++)
      given.push_back({encoder->vertices[v][0], encoder->vertices[v][1], encoder->vertices[v][2]});
    const Encoded encoded(*encoder, i % 4 == 0 ? withEdges(quadsX, quadsY) : whole(quadsX, quadsY));
    const VertHeader* const block = encoded.block();
    ASSERT_EQ(validateVert(block, encoded.size).message(), "") << "sheet " << i;
    ASSERT_LE(encoded.size, (vertLayout(block->region, block->info).rawBytes + 3) & ~3u) << "larger than a raw block";
    const auto decoded = std::make_unique<DecodedBlock>(block);
    for (size_t v = 0; v < given.size(); v++)
      for (int k = 0; k < 3; k++)
        ASSERT_TRUE(sameFloat(decoded->vertices[v][k], given[v][k]))
            << "sheet " << i << ", vertex " << v << ", axis " << k;
    raw += encoded.statistics.raw;
    withRemainders += hasRemainders(block->info);
    if (encoded.statistics.raw) continue;
    ASSERT_EQ((size_t(decoded->end - encoded.bytes) + 3) & ~size_t(3), encoded.size) << "unused bytes";
    sheared += shearSlope(block->info, 1) != 0;
    // boxes and bounds of the stored vertices, in long double
    const int m = shearedAxis(block->info);
    auto coordinate = [&](const float* p, int k) {
      if (k != m) return (long double)p[k];
      long double h = (long double)p[m] - block->origin[m];
      for (int n : {1, 2})
        h += shearSlope(block->info, n) / 16.0L * ((long double)p[(m + n) % 3] - block->origin[(m + n) % 3]);
      return h;
    };
    const VertLayout layout = vertLayout(block->region, block->info);
    const float extent =
        vertExtent(block->info, block->bounds, boundsUnit(block->info), vertSpacing(block->word, block->corners));
    for (uint32_t g = 0; g < layout.groups; g++) {
      float lower[3], upper[3];
      decoded->groupBox(g, lower, upper);
      for (int k = 0; k < 3; k++)
        for (float plane : {lower[k], upper[k]})
          ASSERT_LE(std::fabs((long double)plane - (k == m ? 0 : block->origin[k])), extent) << "sheet " << i;
      const uint32_t x0 = groupQuads * (g % layout.groupsX), y0 = groupQuads * (g / layout.groupsX);
      for (uint32_t y = y0; y <= std::min(y0 + groupQuads, quadsY); y++)
        for (uint32_t x = x0; x <= std::min(x0 + groupQuads, quadsX); x++)
          for (int k = 0; k < 3; k++) {
            ASSERT_LE(std::fabs((long double)decoded->vertex(x, y)[k] - block->origin[k]), extent) << "sheet " << i;
            const long double c = coordinate(decoded->vertex(x, y), k);
            ASSERT_TRUE(lower[k] <= c && c <= upper[k]) << "sheet " << i << ", group " << g << ", axis " << k;
            const long double step = (long double)spacingOf(block, k) * boundsUnit(block->info),
                              from = k == m ? c : c - block->origin[k];
            const int of = k == m ? 3 : (k - m + 2) % 3;
            ASSERT_TRUE((k == m ? step * encodedBound(block->bounds, 2) : 0) <= from &&
                        from <= step * encodedBound(block->bounds, of))
                << "sheet " << i << ", axis " << k;
          }
    }
  }
  EXPECT_LT(raw, 1200u);
  EXPECT_GT(withRemainders, 1500u);
  EXPECT_GT(sheared, 500u);
}

TEST(VertBlock, SheetOfFloatsIsSmallerThanFloats) {
  Random random(seed + 4);
  auto encoder = std::make_unique<VertEncoder>();
  // heights that use all bits, over a plane whose vertices are integers far from the origin, as in terrains
  for (uint32_t y = 0; y <= 16; y++)
    for (uint32_t x = 0; x <= 16; x++) {
      float* v = encoder->vertices[17 * y + x];
      v[0] = float(2700000 + 2 * x);
      v[1] = float(1180000 + 2 * y);
      v[2] = float(431.7 + 0.4 * x - 0.1 * y + 0.01 * random.normal());
    }
  const Encoded encoded(*encoder, whole(16, 16));
  EXPECT_LT(encoded.size, 256 * 2.6);
  const VertHeader* const block = encoded.block();
  EXPECT_GE(spacingOf(block, 0), 0.25f);
  EXPECT_LE(spacingOf(block, 2), std::ldexp(1.0f, -9));
}

TEST(VertBlock, StrayVertexAndItsNeighborRoundTrip) {
  auto encoder = std::make_unique<VertEncoder>();
  for (float stray : {1e6f, 1e12f, 1e18f}) {
    for (int v = 0; v < 17 * 17; v++)
      for (int k = 0; k < 3; k++)
        encoder->vertices[v][k] = float((k == 0 ? v % 17 : k == 1 ? v / 17 : (v * v) % 7) + 0.1 * k) * 0.01f;
    encoder->vertices[100][1] = stray;
    const float beside = encoder->vertices[101][1];
    const Encoded encoded(*encoder, whole(16, 16));
    const auto decoded = std::make_unique<DecodedBlock>(encoded.block());
    EXPECT_EQ(decoded->vertices[100][1], stray);
    EXPECT_EQ(decoded->vertices[101][1], beside);
  }
}

TEST(VertBlock, CoordinatesBeyond14BitsHaveRemainders) {
  auto encoder = std::make_unique<VertEncoder>();
  for (int width : {16383, 16384}) {
    for (int v = 0; v < 9 * 9; v++) {
      encoder->vertices[v][0] = float(v % 9) * 0.125f * float(width - 1) + float(v == 8);
      encoder->vertices[v][1] = float(v / 9);
      encoder->vertices[v][2] = 0;
    }
    encoder->vertices[8][0] = float(width);
    const Encoded encoded(*encoder, whole(8, 8));
    EXPECT_FALSE(encoded.statistics.raw);
    EXPECT_TRUE(hasRemainders(encoded.block()->info)) << width; // eighths: 17 bits
  }
}

TEST(VertBlock, SpacingsAreTheFinestOfExactBoxes) {
  const struct {
    float x[3], spacing;
  } columns[] = {
      // planes of boxes are up to 2^15 spacings outside the vertices, and floats are exact up to 2^24
      {{16744440, 16744441, 16744448}, 1},
      {{-16744448, -16744441, -16744440}, 1},
      {{16744440, 16744441, 16744449}, 2},
      {{-16744449, -16744441, -16744440}, 2},
      // stored as floats: boxes have at least 64 spacings
      {{-1, 1e-20f, 1}, 1 / 32.0f},
      {{-3, 1e-20f, 0.99f}, 1 / 32.0f},
      {{0x1p-20f, 1e-20f, 0.99f}, 1 / 128.0f},
  };
  auto encoder = std::make_unique<VertEncoder>();
  for (const auto& of : columns) {
    for (int v = 0; v < 3 * 9; v++) {
      encoder->vertices[v][0] = of.x[v % 3];
      encoder->vertices[v][1] = float(v / 3);
      encoder->vertices[v][2] = 0;
    }
    const Encoded encoded(*encoder, whole(2, 8));
    EXPECT_FALSE(encoded.statistics.raw);
    EXPECT_EQ(spacingOf(encoded.block(), 0), of.spacing) << of.x[0] << " to " << of.x[2];
  }
}

// The quotient of a tiny coordinate and a large one is less than all positive floats.
TEST(VertBlock, TinyCoordinatesNextToLargeOnesRoundTrip) {
  auto encoder = std::make_unique<VertEncoder>();
  for (int v = 0; v < 4 * 4; v++)
    for (int k = 0; k < 3; k++) encoder->vertices[v][k] = v == 5 ? 0x1p-120f : std::ldexp(float(v), 56);
  const Encoded encoded(*encoder, whole(3, 3));
  const auto decoded = std::make_unique<DecodedBlock>(encoded.block());
  for (int v = 0; v < 4 * 4; v++)
    for (int k = 0; k < 3; k++) EXPECT_EQ(decoded->vertices[v][k], v == 5 ? 0x1p-120f : std::ldexp(float(v), 56));
}

// A tiny negative coordinate lies below 0 by far less than a double's ulp at 1.
TEST(VertBlock, BoxesContainTinyNegativeCoordinates) {
  auto encoder = std::make_unique<VertEncoder>();
  for (int axis = 0; axis < 3; axis++) {
    for (int v = 0; v < 9 * 9; v++)
      for (int k = 0; k < 3; k++) encoder->vertices[v][k] = float(k == (axis + 1) % 3 ? v % 9 : v / 9);
    for (int v = 0; v < 9 * 9; v++) encoder->vertices[v][axis] = v % 9 == 8 ? 64 : -1e-20f;
    const Encoded encoded(*encoder, whole(8, 8));
    ASSERT_FALSE(encoded.statistics.raw);
    ASSERT_NE(axis, shearedAxis(encoded.block()->info));
    const auto decoded = std::make_unique<DecodedBlock>(encoded.block());
    float lower[3], upper[3];
    decoded->groupBox(0, lower, upper);
    EXPECT_LE(lower[axis], -1e-20f) << "axis " << axis;
  }
}

TEST(VertBlock, EncoderWritesAnnotatedBlock) {
  auto encoder = std::make_unique<VertEncoder>();
  for (int j = 0; j <= 2; j++)
    for (int i = 0; i <= 5; i++) {
      float* v = encoder->vertices[6 * j + i];
      v[0] = float(100 + 8 * i);
      v[1] = float(8 * j);
      v[2] = float(i * i - (i == 1 && j == 1 ? 12 : 0));
    }
  Encoded encoded(*encoder, {packRegion(5, 2, 16, 0), packPatchQuads(21, 2), packEdges(21, 2, 7, 2, 0, 0)});
  VertHeader* block = (VertHeader*)encoded.bytes;
  block->surface = 3;
  block->primID = 5;
  expectAnnotatedBytes(block, encoded.size, "A cVERT block");
}

TEST(VertBlock, ReservedBitsAreUnsupported) {
  Random random(seed + 6);
  auto encoder = std::make_unique<VertEncoder>();
  for (double roughness : {0.0, 3.0}) {
    const Sheet sheet(random, 5, 3, roughness);
    sheet.fill(*encoder);
    Encoded encoded(*encoder, withEdges(5, 3));
    ASSERT_EQ(validateVert(encoded.bytes, encoded.size).message(), "");
    const auto expectUnsupported = [&](size_t offset, uint32_t bit) {
      encoded.bytes[offset + bit / 8] ^= uint8_t(1u << bit % 8);
      EXPECT_EQ(validateVert(encoded.bytes, encoded.size).code, ErrorCode::UNSUPPORTED) << offset << ", bit " << bit;
      encoded.bytes[offset + bit / 8] ^= uint8_t(1u << bit % 8);
    };
    for (size_t corner = 8; corner < 12; corner++) expectUnsupported(vertCornersOffset + 2 * corner, 14);
    for (size_t edge = 2; edge < 4; edge++)
      for (uint32_t bit = 12; bit < 16; bit++) expectUnsupported(vertHeaderBytes + 2 * edge, bit);
  }
}

TEST(VertCell, PredictionsAreBilinearAndInterpolateCorners) {
  Random random(seed + 4);
  for (int n = 0; n < 20000; n++) {
    int c[4];
    for (int& x : c) x = int(random.below(maxExtent));
    const int quads = 1 + int(random.below(4)), i = int(random.below(5)), j = int(random.below(5));
    const int wx = cellWeight(i, 1, quads), wy = cellWeight(j, 1, quads);
    if (quads != 3) { EXPECT_EQ(wx, 16 * std::min(i, quads) / quads); }
    const double x = wx / 16.0, y = wy / 16.0;
    const double exact = c[0] * (1 - x) * (1 - y) + c[1] * x * (1 - y) + c[2] * (1 - x) * y + c[3] * x * y;
    EXPECT_EQ(cellPrediction(c[0], c[1], c[2], c[3], wx, wy), int(std::floor(exact + 0.5)));
    EXPECT_EQ(cellPrediction(c[0], c[1], c[2], c[3], 16, 16), c[3]);
  }
}

TEST(VertCell, SlopesAreRoundedToSixteenths) {
  for (int slope = -maxSlope; slope <= maxSlope; slope++)
    for (int main = -300; main <= 300; main++)
      EXPECT_EQ(slopeResidual(slope, main), int(std::floor(slope * main / 16.0 + 0.5)));
}

// The largest supported power of two up to the requested spacing.
TEST(WorldLattice, ExponentsMatchRequestedSpacing) {
  EXPECT_EQ(latticeExponent(0.25), -2);
  EXPECT_EQ(latticeExponent(0.3), -2);
  EXPECT_EQ(latticeExponent(0), minLatticeExponent);
  EXPECT_EQ(latticeExponent(1e-38), minLatticeExponent);
  EXPECT_EQ(latticeExponent(1e38), maxLatticeExponent);
}

// Computed in long double, which represents multiples of the spacing exactly.
TEST(WorldLattice, VerticesMoveByAtMostHalfASpacing) {
  Random random(seed + 6);
  for (int i = 0; i < 200000; i++) {
    const int exponent = minLatticeExponent + int(random.below(maxLatticeExponent - minLatticeExponent + 1));
    const float x = float(std::ldexp(random.uniform(-1, 1), std::max(exponent - 10 + int(random.below(60)), -120)));
    if (!std::isfinite(x)) continue;
    const WorldLattice lattice(exponent);
    const long double spacing = std::ldexp(1.0L, exponent), snapped = lattice.snap(x);
    ASSERT_LE(std::fabs(snapped - x), spacing / 2) << x << " on 2^" << exponent;
    ASSERT_EQ(std::fmod(snapped, spacing), 0.0L) << x << " on 2^" << exponent;
    float four[4];
    lattice.snap(Float4(x)).store(four);
    ASSERT_EQ(four[0], float(snapped));
  }
}

TEST(WorldLattice, ExactVerticesDoNotMove) {
  for (float x : {0.1f, 1e-30f, -3e-38f, 1e30f, INFINITY}) EXPECT_EQ(WorldLattice(losslessExponent).snap(x), x);
}

// The same as stitch() of upstream's tessellation.h, which determines GRID's vertices.
TEST(VertParameters, StitchedVerticesMatchEmbree) {
  for (uint32_t quads = 1; quads <= 256; quads += quads < 20 ? 1 : 17)
    for (uint32_t rate = 1; rate <= quads; rate++) {
      EXPECT_EQ(stitchedVertex(0, quads, rate), 0u);
      EXPECT_EQ(stitchedVertex(quads, quads, rate), rate);
      for (uint32_t x = 0; x <= quads; x++) {
        const double exact = double(x) * rate / quads;
        ASSERT_EQ(stitchedVertex(x, quads, rate), uint32_t(std::floor(exact + 0.5 * rate / quads)));
        if (rate == quads) { ASSERT_EQ(vertParameter<float>(x, quads, rate), float(x) / float(quads)); }
      }
    }
}

}} // namespace programs::test
