// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares the traversal's decoder of moving mesh blocks with the scalar one: all segments, all groups at both ends
 * exactly. Between the ends, boxes must contain the vertices in the same float arithmetic. Compiled once for every ISA,
 * outside of the library. */

#include "kernels/cbvh/exact/moving_mesh_block.h"
#include "kernels/cvert/decoder/decoded_mesh.h"
#include "support/moving_mesh.h"

#include <gtest/gtest.h>

#include <memory>

// for isa_check.cpp
extern const char* const programIsa;
const char* const programIsa = TEST_ISA;

namespace programs::test { namespace {

using namespace embree::cbvh;
using namespace embree::isa::cbvh;

void expectSegment(const MeshHeader* block, uint32_t segment, float fraction) {
  auto entry = std::make_unique<MeshSegmentEntry>();
  auto group = std::make_unique<SegmentTriangles>();
  const MeshMotionDecoder decoder(block);
  entry->key = {block, segment, 0};
  decoder.decode(segment, *entry);
  const MeshView view(block);
  std::unique_ptr<DecodedMesh> ends[2];
  for (uint32_t e = 0; e < 2; e++) ends[e] = std::make_unique<DecodedMesh>(block, segment + e);
  const embree::Ray ray(embree::Vec3fa(0, 0, 0), embree::Vec3fa(0, 0, 1), 0.0f, INFINITY);
  VertRay vertRay;
  vertRay.set(ray);
  const MovingMeshBlock moving(vertRay, (const VertHeader*)block, TimeInMotion{segment, fraction});
  const GroupBoxes& now = moving.boxes();
  ASSERT_EQ(now.lanes, (1u << view.groups) - 1);
  ASSERT_EQ(now.shearedAxis, 3);
  for (uint32_t g = 0; g < view.groups; g++) {
    const uint32_t count = view.firstTriangle[g + 1] - view.firstTriangle[g];
    for (uint32_t t = 0; t < count; t++) {
      const uint32_t i = view.firstTriangle[g] + t, half = t >> 4, lane = t & 15;
      if (lane == 0) {
        decoder.triangles(*entry, g, half, *group);
        ASSERT_EQ(group->begin.lanes, (1u << std::min(16u, count - 16 * half)) - 1);
        ASSERT_EQ(group->begin.hasNextHalf, half == 0 && count > 16);
      }
      const MeshTriangles& atTime = moving.triangles(g, half);
      ASSERT_EQ(atTime.lanes, group->begin.lanes);
      ASSERT_EQ(atTime.hasNextHalf, group->begin.hasNextHalf);
      ASSERT_EQ(moving.point(g, t, 0.25f, 0.5f).primID, ends[0]->numbers[i]);
      for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++) {
          const uint32_t v = ends[0]->triangles[i][c];
          const uint32_t local = group->begin.corners[c][lane];
          ASSERT_EQ(atTime.corners[c][lane], local);
          const float a = ends[0]->vertices[v][k], b = ends[1]->vertices[v][k], p = atTime.vertices.at[k][local];
          ASSERT_EQ(group->begin.vertices.at[k][local], a) << "group " << g << ", triangle " << t;
          ASSERT_EQ(group->end.at[k][local], b) << "group " << g << ", triangle " << t;
          ASSERT_NEAR(p, (1 - double(fraction)) * a + double(fraction) * b, 1e-6 * (std::fabs(a) + std::fabs(b)));
          if (fraction == 0) { ASSERT_EQ(p, a); }
          if (fraction == 1) { ASSERT_EQ(p, b); }
          ASSERT_TRUE(now.planes[k].at[0][g] <= p && p <= now.planes[k].at[1][g])
              << "group " << g << ", axis " << k << ": " << p << " is not from " << now.planes[k].at[0][g] << " to "
              << now.planes[k].at[1][g];
          ASSERT_LE(std::fabs(p - now.origin[k]), now.extent[k]);
        }
    }
  }
}

TEST(MeshMotionDecoding, SegmentsMatchScalarDecoder) {
  Random random(3171);
  auto encoder = std::make_unique<MeshMotionEncoder>();
  MeshStatistics statistics;
  for (int i = 0; i < 120; i++) {
    const MovingMesh mesh = sheetOfSeries(random, i);
    for (const EncodedBlock& encoded : encode(*encoder, mesh, anyGroupTriangles(random), statistics)) {
      // decoders may read bytes after the block
      Words words = encoded.words;
      words.resize(words.size() + 16);
      embree::cbvh::invalidateThreadCaches();
      for (uint32_t segment = 0; segment + 1 < mesh.steps.size(); segment++)
        for (float fraction : {0.0f, 1.0f, float(random.uniform())}) {
          expectSegment((const MeshHeader*)words.data(), segment, fraction);
          if (HasFatalFailure()) FAIL() << "sheet " << i << ", segment " << segment << ", at " << fraction;
        }
    }
  }
  EXPECT_GT(statistics.rankAxes, 20u);
  EXPECT_GT(statistics.shearedBlocks, 20u);
}

}} // namespace programs::test
