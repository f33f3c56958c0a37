// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The table of kinds in a library without the paper's representations: this program is compiled as its files are. */

#include "kernels/cbvh/base/kinds.h"

#include <gtest/gtest.h>

namespace cbvh::test {
namespace {

using namespace embree::cbvh;

TEST(KindsWithoutPaper, AreCvertAlone)
{
  ASSERT_EQ(numKinds, 1u);
  EXPECT_EQ(kindDescriptions[0].kind, Kind::VERT);
}

// A file whose record names cLEAF may have cVERT blocks alone, by exactFaces: commits and verbosity 1 report what is
// traced, not GRID.
TEST(KindsWithoutPaper, LoadedGeometriesAreReportedAsWhatTheyHave)
{
  for (uint32_t compression = RTC_COMPRESSION_GRID; compression <= RTC_COMPRESSION_VERT; compression++) {
    Kind kind = Kind::GRID;
    ASSERT_TRUE(findKind(compressionOfLoaded(compression), kind)) << compression;
    EXPECT_EQ(kind, Kind::VERT);
  }
}

} // namespace
} // namespace cbvh::test
