// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "batches.h"
#include "building/memory.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace programs::test { namespace {

constexpr size_t quads = 1000;

size_t bytes(RepresentationKind kind) { return estimatedPeakBytes(kind, quads); }

TEST(Batches, RepresentationsThatFitAreMeasuredAlternately) {
  const Batches plan =
      planBatches(parseRepresentations("naive,grid,cvoxel,cleaf", 2), {"avx2", "sse2"}, quads, SIZE_MAX);
  ASSERT_EQ(plan.baselines.size(), 2u) << "GRID, one per ISA";
  ASSERT_EQ(plan.batches.size(), 1u);
  EXPECT_EQ(plan.batches[0].size(), 6u) << "GRID is not a separate variant";
  EXPECT_TRUE(plan.tooLarge.empty());
}

TEST(Batches, GridIsAlwaysIncluded) {
  const Batches plan = planBatches(parseRepresentations("cleaf", 2), {"avx2"}, quads, SIZE_MAX);
  EXPECT_EQ(plan.baselines.size(), 1u);
}

TEST(Batches, BatchesFitIntoFreeMemory) {
  const size_t available = bytes(RepresentationKind::Grid) + 2 * bytes(RepresentationKind::CLeaf);
  const auto representations = parseRepresentations("naive,cleaf^0,cleaf^1,cleaf^2,cleaf^3,cleaf^4", 2);
  const Batches plan = planBatches(representations, {"avx2"}, quads, available);
  ASSERT_EQ(plan.tooLarge.size(), 1u);
  EXPECT_EQ(plan.tooLarge[0].representation.kind, RepresentationKind::Naive);
  EXPECT_GT(neededBytes(plan, plan.tooLarge[0], quads), available);
  size_t variants = 0;
  for (const auto& batch : plan.batches) {
    size_t used = bytes(RepresentationKind::Grid);
    for (const Variant& v : batch) used += bytes(v.representation.kind);
    EXPECT_LE(used, available);
    variants += batch.size();
  }
  EXPECT_EQ(variants, 5u);
  EXPECT_EQ(plan.batches.size(), 3u);
}

TEST(Batches, LibrariesAreComparedInOneBatch) {
  const size_t available = 2 * bytes(RepresentationKind::Grid) + 3 * bytes(RepresentationKind::CLeaf);
  const Batches plan =
      planBatches(parseRepresentations("naive,cleaf^1,cleaf^2", 2), {"avx2"}, quads, available, {true, true});
  EXPECT_EQ(plan.baselines.size(), 2u) << "GRID, one per library";
  ASSERT_EQ(plan.batches.size(), 2u);
  for (const auto& batch : plan.batches) {
    ASSERT_EQ(batch.size(), 2u);
    EXPECT_TRUE(differOnlyByLibrary(batch[0], batch[1]));
    EXPECT_EQ(batch[0].library, 0u);
    EXPECT_EQ(batch[1].library, 1u);
  }
  ASSERT_EQ(plan.tooLarge.size(), 2u) << "NAIVE, for both";
  EXPECT_EQ(neededBytes(plan, plan.tooLarge[0], quads),
            2 * bytes(RepresentationKind::Grid) + 2 * bytes(RepresentationKind::Naive));
}

TEST(Batches, StockEmbreeHasNoCompressedRepresentations) {
  const Batches plan = planBatches(parseRepresentations("naive,cvert", 2), {"avx2"}, quads, SIZE_MAX, {false, true});
  ASSERT_EQ(plan.batches.size(), 1u);
  ASSERT_EQ(plan.batches[0].size(), 3u);
  EXPECT_EQ(plan.batches[0][2].representation.kind, RepresentationKind::CVert);
  EXPECT_EQ(plan.batches[0][2].library, 1u);
  ASSERT_EQ(plan.unsupported.size(), 1u);
  EXPECT_EQ(plan.unsupported[0].library, 0u);
}

}} // namespace programs::test
