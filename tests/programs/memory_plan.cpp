// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "memory_plan.h"
#include "basics/error.h"
#include "building/memory.h"
#include "support/message_parts.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace cbvh::test {
namespace {

constexpr size_t quads = 1000000;

std::string builtOf(const MemoryPlan& plan)
{
  std::string list;
  for (const Representation& r : plan.built)
    list += (list.empty() ? "" : ",") + r.fileStem();
  return list;
}

MemoryPlan plan(const std::string& asked, size_t available)
{
  return planMemory(parseRepresentations(asked, 2), quads, available);
}

size_t peak(RepresentationKind kind)
{
  return estimatedPeakBytes(kind, quads);
}

TEST(MemoryPlan, EverythingThatFitsIsBuiltGridFirst)
{
  const MemoryPlan all = plan("cleaf,naive,grid,cvert", SIZE_MAX);
  EXPECT_EQ(builtOf(all), "grid,naive,cleaf2,cvert");
  EXPECT_TRUE(all.skipped.empty());
  EXPECT_EQ(builtOf(plan("cleaf,naive-compact,naive,grid", SIZE_MAX)), "grid,naive,naive-compact,cleaf2");
  EXPECT_EQ(builtOf(plan("cleaf", SIZE_MAX)), "cleaf2") << "only requested representations are built";
}

TEST(MemoryPlan, ReferencesAreLeftOutBeforeCompressedOnes)
{
  const size_t grid = peak(RepresentationKind::Grid), naive = peak(RepresentationKind::Naive),
               leaf = peak(RepresentationKind::CLeaf);
  EXPECT_EQ(builtOf(plan("naive,grid,cleaf", grid + naive)), "grid,naive,cleaf2");
  EXPECT_EQ(builtOf(plan("naive,grid,cleaf", grid + naive - 1)), "grid,cleaf2") << "NAIVE is built while GRID exists";
  EXPECT_LT(peak(RepresentationKind::NaiveCompact), naive);
  EXPECT_EQ(builtOf(plan("naive,naive-compact,grid,cleaf", grid + naive - 1)), "grid,naive-compact,cleaf2");
  EXPECT_EQ(builtOf(plan("naive-compact,grid,cleaf", grid + peak(RepresentationKind::NaiveCompact) - 1)),
            "grid,cleaf2");
  EXPECT_EQ(builtOf(plan("naive,grid,cleaf", grid + leaf)), "grid,cleaf2");
  const MemoryPlan alone = plan("naive,grid,cleaf", grid + leaf - 1);
  EXPECT_EQ(builtOf(alone), "cleaf2");
  ASSERT_EQ(alone.skipped.size(), 2u);
  EXPECT_TRUE(containsInOrder(alone.skipped[0], {"GRID is left out", "1.0 million quads"}));
  EXPECT_NE(alone.skipped[1].find("NAIVE is left out"), std::string::npos);
}

TEST(MemoryPlan, CompressedRepresentationThatDoesNotFitIsLeftOut)
{
  EXPECT_EQ(builtOf(plan("cgrid,cleaf", peak(RepresentationKind::CGrid) - 1)), "cleaf2");
}

TEST(MemoryPlan, TimeStepsRequireMoreMemory)
{
  for (RepresentationKind kind : {RepresentationKind::Naive, RepresentationKind::NaiveCompact,
                                  RepresentationKind::Grid, RepresentationKind::CGrid, RepresentationKind::CLeaf,
                                  RepresentationKind::CVert})
    EXPECT_LT(estimatedPeakBytes(kind, {quads, 2}), estimatedPeakBytes(kind, {quads, 3})) << int(kind);
  EXPECT_EQ(estimatedPeakBytes(RepresentationKind::CGrid, {quads, 2}),
            estimatedPeakBytes(RepresentationKind::CVert, {quads, 2}))
    << "moving surfaces use cVERT";
  const std::vector<Representation> asked = parseRepresentations("grid,cvert", 2);
  const size_t still = peak(RepresentationKind::Grid) + peak(RepresentationKind::CVert);
  EXPECT_EQ(builtOf(planMemory(asked, {quads, 1}, still)), "grid,cvert");
  EXPECT_EQ(builtOf(planMemory(asked, {quads, 2}, still)), "cvert");
}

TEST(MemoryPlan, NoRepresentationThatFitsIsAnError)
{
  EXPECT_THROW(plan("grid,cleaf", 1000), Error);
}

} // namespace
} // namespace cbvh::test
