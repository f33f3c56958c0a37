// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The table of kinds in a library without the paper's representations. This program is compiled with the same options.
 * */

#include "kernels/cbvh/base/kinds.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

using namespace embree::cbvh;

TEST(KindsWithoutPaper, OnlyExactKindsAreAvailable) {
  ASSERT_EQ(numKinds, 2u);
  EXPECT_EQ(kindDescriptions[0].kind, Kind::CVERT);
  EXPECT_EQ(kindDescriptions[1].kind, Kind::CTILE);
}

// A record may name cLEAF although all blocks are cVERT, because of fallbackFaces. Reports must name the traced
// representation, not GRID.
TEST(KindsWithoutPaper, LoadedGeometriesReportTheirBlocks) {
  for (uint32_t compression = RTC_COMPRESSION_CGRID; compression <= RTC_COMPRESSION_CVERT; compression++) {
    Kind kind = Kind::CGRID;
    ASSERT_TRUE(findKind(compressionOfLoaded(compression), kind)) << compression;
    EXPECT_EQ(kind, Kind::CVERT);
  }
}

}} // namespace programs::test
