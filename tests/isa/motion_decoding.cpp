// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares the traversal's decoder of moving cVERT blocks with the scalar one: random segments, all groups at both ends
 * exactly. Between the ends, boxes must contain the vertices in the same float arithmetic. Compiled once for every
 * ISA, outside of the library. */

#include "kernels/cbvh/exact/moving_block.h"
#include "kernels/cvert/decoder/decoded_block.h"
#include "support/moving_sheet.h"

#include <gtest/gtest.h>

#include <memory>

// for isa_check.cpp
extern const char* const programIsa;
const char* const programIsa = TEST_ISA;

namespace programs::test { namespace {

using namespace embree::cbvh;
using namespace embree::isa::cbvh;

// True if the planes of a group's box contain a vertex along an axis; the sheared coordinate is computed in double
// precision.
bool contains(const GroupBoxes& boxes, uint32_t lane, int k, const float p[3]) {
  double c = p[k];
  if (k == boxes.shearedAxis) {
    c = 0;
    for (int a = 0; a < 3; a++) c += double(boxes.shear[a]) * (double(p[a]) - boxes.origin[a]);
  }
  return boxes.planes[k].at[0][lane] <= c && c <= boxes.planes[k].at[1][lane];
}

TEST(MotionDecoding, SegmentsMatchScalarDecoder) {
  Random random(3161);
  auto encoder = std::make_unique<MotionEncoder>();
  auto entry = std::make_unique<VertSegmentEntry>();
  auto group = std::make_unique<SegmentVertices>();
  size_t raw = 0, sheared = 0, turned = 0;
  for (int i = 0; i < 700; i++) {
    const MovingSheet sheet(random, 1 + random.below(16), 1 + random.below(16), i);
    const EncodedMotion encoded(*encoder, sheet);
    const VertHeader* const block = encoded.block();
    turned += encoded.statistics.rotatedGroups;
    const uint32_t segment = random.below(uint32_t(sheet.steps.size()) - 1);
    const MotionDecoder decoder(block);
    entry->key = {block, segment, 0};
    decoder.decode(segment, *entry);
    const auto before = std::make_unique<DecodedBlock>(block, segment),
               after = std::make_unique<DecodedBlock>(block, segment + 1);
    raw += entry->shearedAxis == 3;
    sheared += entry->shearedAxis < 3 && entry->shear[(entry->shearedAxis + 1) % 3] != 0;
    const float fraction = i % 3 == 0 ? float(i % 2) : float(random.uniform());
    embree::cbvh::invalidateThreadCaches();
    const MovingVertBlock moving(block, TimeInMotion{segment, fraction});
    const GroupBoxes& now = moving.boxes();
    ASSERT_EQ(now.lanes, entry->lanes);
    for (uint32_t rest = entry->lanes; rest; rest &= rest - 1) {
      const uint32_t lane = uint32_t(__builtin_ctz(rest));
      decoder.vertices(*entry, lane, *group);
      const CellVertices& atTime = moving.vertices(lane);
      for (uint32_t y = 0; y < 5; y++)
        for (uint32_t x = 0; x < 5; x++) {
          const uint32_t column = std::min(4 * (lane & 3) + x, sheet.quadsX),
                         row = std::min(4 * (lane >> 2) + y, sheet.quadsY);
          for (int e = 0; e < 2; e++)
            for (int k = 0; k < 3; k++) {
              const float a = group->vertices[e].at[k][laneOfVertex(x, y)],
                          b = (e ? *after : *before).vertex(column, row)[k];
              ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b)))
                  << a << " for " << b << ": sheet " << i << ", segment " << segment << ", end " << e << ", lane "
                  << lane;
            }
        }
      for (int v = 0; v < cellVertices; v++) {
        const float p[3] = {atTime.at[0][v], atTime.at[1][v], atTime.at[2][v]};
        if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))) continue;
        for (int k = 0; k < 3; k++)
          ASSERT_TRUE(contains(now, lane, k, p))
              << "sheet " << i << ", lane " << lane << ", vertex " << v << ", axis " << k << ", at " << fraction;
      }
    }
  }
  EXPECT_GT(raw, 50u);
  EXPECT_GT(sheared, 100u);
  EXPECT_GT(turned, 2000u);
}

// Bounds of whole blocks must not cull rays that hit a vertex.
TEST(MotionDecoding, BlockBoundsContainVerticesAtAllTimes) {
  Random random(3162);
  auto encoder = std::make_unique<MotionEncoder>();
  size_t rays = 0, missed = 0;
  for (int i = 0; i < 400; i++) {
    const MovingSheet sheet(random, 1 + random.below(16), 1 + random.below(16), i);
    const EncodedMotion encoded(*encoder, sheet);
    const VertHeader* const block = encoded.block();
    const uint32_t segment = random.below(uint32_t(sheet.steps.size()) - 1);
    embree::cbvh::invalidateThreadCaches();
    const MovingVertBlock moving(block, TimeInMotion{segment, float(random.uniform())});
    const GroupBoxes& now = moving.boxes();
    for (int r = 0; r < 20 && now.lanes; r++) {
      uint32_t lane;
      do lane = random.below(16);
      while (!((now.lanes >> lane) & 1));
      const CellVertices& atTime = moving.vertices(lane);
      const uint32_t v = random.below(cellVertices);
      const float p[3] = {atTime.at[0][v], atTime.at[1][v], atTime.at[2][v]};
      if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))) continue;
      float org[3], dir[3];
      for (int k = 0; k < 3; k++) {
        dir[k] = float(random.normal()) * 600 * sheet.spacings[segment];
        org[k] = p[k] - dir[k];
        dir[k] = p[k] - org[k];
      }
      const embree::Ray ray(embree::Vec3fa(org[0], org[1], org[2]), embree::Vec3fa(dir[0], dir[1], dir[2]), 0.0f,
                            INFINITY);
      VertRay pre;
      pre.set(ray);
      rays++;
      missed += !moving.mayIntersect(pre, 0.0f, INFINITY);
    }
  }
  EXPECT_GT(rays, 5000u);
  EXPECT_EQ(missed, 0u);
}

}} // namespace programs::test
