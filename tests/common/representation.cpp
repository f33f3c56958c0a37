// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/representation.h"
#include "basics/error.h"

#include <gtest/gtest.h>

namespace cbvh::test {
namespace {

TEST(Representation, ListsTakeFrameLevelsOfTheirOwn)
{
  const auto list = parseRepresentations("NAIVE,grid,cGRID,cvoxel^3,cleaf:0,cleaf:auto", 2);
  ASSERT_EQ(list.size(), 6u);
  EXPECT_EQ(list[0].deviceConfig(), "");
  EXPECT_EQ(list[1].deviceConfig(), "subdiv_accel=bvh4.grid.eager");
  EXPECT_EQ(list[2].deviceConfig(), "subdiv_accel=cbvh.grid,cbvh_frame_level=2");
  EXPECT_EQ(list[3].deviceConfig(), "subdiv_accel=cbvh.voxel,cbvh_frame_level=3");
  EXPECT_EQ(list[3].label(), "cVOXEL^3");
  EXPECT_EQ(list[4].fileStem(), "cleaf0");
  EXPECT_EQ(list[5].deviceConfig(), "subdiv_accel=cbvh.leaf,cbvh_frame_level=auto");
}

TEST(Representation, RefusesWhatItDoesNotKnow)
{
  for (const char* list : {"", "grid,", "mesh", "grid^2", "cleaf^9", "cleaf^-1", "cleaf^", "cleaf^2x", "cleaf,cleaf^2"})
    EXPECT_THROW(parseRepresentations(list, 2), Error) << list;
  EXPECT_NO_THROW(parseRepresentations("cleaf,cleaf^3", 2));
}

} // namespace
} // namespace cbvh::test
