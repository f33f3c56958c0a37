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

TEST(Representation, ListsAreOfTheLibrarysKinds)
{
  EXPECT_EQ(listOfRepresentations(",", " or "), "naive,grid,cgrid,cvoxel,cleaf or cvert");
  const auto list = parseRepresentations(listOfRepresentations(","), autoFrameLevel);
  const std::vector<RTCCompression> compressions = {RTC_COMPRESSION_NONE,  RTC_COMPRESSION_NONE, RTC_COMPRESSION_GRID,
                                                    RTC_COMPRESSION_VOXEL, RTC_COMPRESSION_LEAF, RTC_COMPRESSION_VERT};
  const std::vector<std::string> labels = {"NAIVE", "GRID", "cGRID", "cVOXEL", "cLEAF", "cVERT"};
  ASSERT_EQ(list.size(), labels.size());
  for (size_t i = 0; i < list.size(); i++)
  {
    SCOPED_TRACE(labels[i]);
    EXPECT_EQ(list[i].kind, representationKinds()[i]);
    EXPECT_EQ(list[i].compression(), compressions[i]);
    EXPECT_EQ(list[i].isCompressed(), i > 1);
    EXPECT_EQ(list[i].hasFrames(), i > 1 && i < 5);
    EXPECT_EQ(list[i].label(), labels[i]);
  }
  EXPECT_EQ(list[5].deviceConfig(), "subdiv_accel=cbvh.vert");
}

TEST(Representation, FrameLevelsEndWithTheLibrarys)
{
  EXPECT_EQ(levelRange(), "0 to 8");
  EXPECT_EQ(parseFrameLevel("8"), 8);
  EXPECT_THROW(parseFrameLevel("9"), Error);
}

TEST(Representation, RefusesWhatItDoesNotKnow)
{
  for (const char* list : {"", "grid,", "mesh", "grid^2", "cleaf^9", "cleaf^-1", "cleaf^", "cleaf^2x", "cleaf,cleaf^2"})
    EXPECT_THROW(parseRepresentations(list, 2), Error) << list;
  EXPECT_NO_THROW(parseRepresentations("cleaf,cleaf^3", 2));
}

} // namespace
} // namespace cbvh::test
