// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The traversal's decoder of cVERT against the scalar one, trace/scalar_vert.h: random blocks of
 * every size, all groups, to the last bit, as nothing rounds. Compiled once for every ISA, outside
 * of the library. */

#include "kernels/cbvh/build/vert_encoder.h"
#include "kernels/cbvh/trace/scalar_vert.h"
#include "kernels/cbvh/trace/vert_group.h"
#include "support/random.h"

#include <memory>
#include <vector>

// for isa_check.cpp
extern const char* const programIsa;
const char* const programIsa = TEST_ISA;

namespace cbvh::test {
namespace {

using namespace embree::cbvh;

// Vertices on a lattice, at every scale of residuals; some blocks are raw.
void fillRandomly(Random& random, VertEncoder& encoder, uint32_t quadsX, uint32_t quadsY, double roughness, float spacing)
{
  double axis[3][3], origin[3];
  for (int k = 0; k < 3; k++) {
    origin[k] = std::floor(random.uniform(-1e5, 1e5));
    for (double* a : {axis[0], axis[1], axis[2]}) a[k] = random.uniform(-60, 60);
  }
  for (uint32_t y = 0; y <= quadsY; y++)
    for (uint32_t x = 0; x <= quadsX; x++) {
      const double h = roughness*random.normal();
      for (int k = 0; k < 3; k++) // 20: not along a normal any more
        encoder.vertices[y*(quadsX + 1) + x][k] = float((origin[k] + std::floor(x*axis[0][k] + y*axis[1][k] + (roughness == 20 ? 1000*random.normal() : h*axis[2][k])))*spacing);
    }
  if (random.chance(0.1)) encoder.vertices[random.below((quadsX + 1)*(quadsY + 1))][0] = INFINITY;
}

TEST(VertDecoding, GroupsEqualTheScalarDecoder)
{
  using namespace embree::isa::cbvh;
  Random random(95);
  auto encoder = std::make_unique<VertEncoder>();
  std::vector<uint8_t> memory(VertEncoder::maxBytes + 32);
  uint8_t* bytes = (uint8_t*)((uintptr_t(memory.data()) + 15) & ~uintptr_t(15));
  unsigned raw = 0, packed = 0, sheared = 0, byAxis = 0;
  for (int i = 0; i < 3000; i++) {
    const uint32_t quadsX = 1 + random.below(16), quadsY = 1 + random.below(16);
    const uint32_t place = vertPlace(quadsX, quadsY, 0, 0, 0, 0);
    const float spacing = std::ldexp(1.0f, int(random.below(20)) - 10);
    fillRandomly(random, *encoder, quadsX, quadsY, std::vector<double>{0, 0.1, 1, 10, 20}[i % 5], spacing);
    VertStatistics statistics;
    ASSERT_GT(encoder->encode(place, spacing, bytes, statistics), 0u);
    (statistics.raw ? raw : packed)++;
    const VertHeader* block = (const VertHeader*)bytes;
    byAxis += !statistics.raw && isByAxis(block->word);
    const auto expected = std::make_unique<ScalarVertBlock>(block);
    const VertLayout layout = vertLayout(place);
    VertGroups groups(block);
    if (!statistics.raw) groups.decodeCorners();
    float boxes[2][3][16];
    for (int k = 0; k < 3; k++) {
      GroupPlanes planes;
      if (!statistics.raw && k == shearedAxis(block->boxForm)) { groups.shearedPlanes(planes); sheared += shearSlope(block->boxForm, 1) != 0; }
      else groups.planes(k, planes);
      for (int lane = 0; lane < 16; lane++) {
        boxes[0][k][lane] = planes.lower[lane/vertWidth][lane % vertWidth];
        boxes[1][k][lane] = planes.upper[lane/vertWidth][lane % vertWidth];
      }
    }
    uint32_t lanes = 0;
    for (uint32_t n = layout.groups; n > 0; n--) { // in any order
      const uint32_t g = (n*7 + 3) % layout.groups, lane = g % layout.groupsX + 4*(g/layout.groupsX);
      lanes |= 1u << lane;
      float lower[3], upper[3];
      expected->groupBox(g, lower, upper);
      for (int k = 0; k < 3; k++) {
        ASSERT_EQ(boxes[0][k][lane], lower[k]);
        ASSERT_EQ(boxes[1][k][lane], upper[k]);
      }
      CellVertices cell;
      groups.decode(lane, cell);
      for (int v = 0; v < cellVertices; v++) {
        const uint32_t x = std::min(groupQuads*(g % layout.groupsX) + v % 5, quadsX), y = std::min(groupQuads*(g / layout.groupsX) + v / 5, quadsY);
        for (int k = 0; k < 3; k++) {
          const float a = cell.at[k][v], b = expected->vertex(x, y)[k];
          ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << a << " for " << b << ": block " << i << " of " << quadsX << " x " << quadsY
            << (statistics.raw ? ", raw" : "") << ", group " << g << ", vertex " << v << ", axis " << k;
        }
      }
    }
  }
  EXPECT_GT(raw, 100u);
  EXPECT_GT(packed, 2000u);
  EXPECT_GT(sheared, 500u);
  EXPECT_GT(byAxis, 100u);
}

} // namespace
} // namespace cbvh::test
