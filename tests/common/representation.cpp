// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/representation.h"
#include "basics/error.h"
#include "programs/warnings.h"
#include "support/message_parts.h"
#include "support/turkish_locale.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <utility>

namespace programs::test { namespace {

TEST(Representation, ListsAcceptFrameLevelsPerEntry) {
  const auto list = parseRepresentations("NAIVE,grid,cGRID,cvoxel^3,cleaf:0,cleaf:auto", 2);
  ASSERT_EQ(list.size(), 6u);
  EXPECT_EQ(list[0].deviceConfig(), "");
  EXPECT_EQ(list[1].deviceConfig(), "subdiv_accel=bvh4.grid.eager");
  EXPECT_EQ(list[2].deviceConfig(), "subdiv_accel=cbvh.grid,cbvh_frame_level=2");
  EXPECT_EQ(list[3].deviceConfig(), "subdiv_accel=cbvh.voxel,cbvh_frame_level=3");
  EXPECT_EQ(list[3].label(), "cVOXEL^3");
  EXPECT_EQ(list[4].fileStem(), "cleaf0");
  EXPECT_EQ(list[5].deviceConfig(), "subdiv_accel=cbvh.leaf,cbvh_fallback_faces=1,cbvh_frame_level=auto");
}

// The one stores faces exactly if leaves represent them badly; the other never does. They must not share a name.
TEST(Representation, LeavesOnlyHasAName) {
  const auto list = parseRepresentations("cleaf^2,cleaf-only^2,cLEAF-only", autoFrameLevel);
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].deviceConfig(), "subdiv_accel=cbvh.leaf,cbvh_fallback_faces=1,cbvh_frame_level=2");
  EXPECT_EQ(list[1].deviceConfig(), "subdiv_accel=cbvh.leaf,cbvh_fallback_faces=0,cbvh_frame_level=2");
  EXPECT_EQ(list[1].label(), "cLEAF-only^2");
  EXPECT_EQ(list[1].fileStem(), "cleaf-only2");
  EXPECT_EQ(list[2].label(), "cLEAF-only");
  EXPECT_EQ(list[1].compression(), RTC_COMPRESSION_CLEAF);
  EXPECT_TRUE(list[0].hasFallbackFaces());
  EXPECT_FALSE(list[1].hasFallbackFaces());
}

TEST(Representation, NamesOfTheLibraryAreAccepted) {
  const std::pair<const char*, const char*> words[] = {{"cvert,CVERT,vert,Vert,cbvh.vert,CBVH.Vert", "cVERT"},
                                                       {"cleaf,leaf,LEAF,cbvh.leaf", "cLEAF"},
                                                       {"cleaf-only,leaf-only,cbvh.leaf-only", "cLEAF-only"},
                                                       {"cvoxel,voxel,cbvh.voxel", "cVOXEL"},
                                                       {"cgrid,cbvh.grid", "cGRID"},
                                                       {"grid,GRID", "GRID"}};
  for (const auto& [list, label] : words)
    for (std::string rest = list; !rest.empty();) {
      const std::string word = rest.substr(0, rest.find(','));
      rest = word == rest ? "" : rest.substr(word.size() + 1);
      SCOPED_TRACE(word);
      EXPECT_EQ(parseRepresentations(word, autoFrameLevel)[0].label(), label);
    }
  EXPECT_EQ(parseRepresentations("Leaf^3", autoFrameLevel)[0].label(), "cLEAF^3");
  for (const char* list :
       {"cvert,vert", "leaf^2,cbvh.leaf:2", "cbvh.naive", "naiv", "aive", "cbvh", "cbvh.cvert", "ccvert"})
    EXPECT_THROW(parseRepresentations(list, 2), Error) << list;
}

TEST(Representation, NamesDoNotDependOnTheLocale) {
  const TurkishLocale locale;
  if (!locale) GTEST_SKIP() << "no localedef, or no source of the Turkish locale: install Debian's package locales";
  ASSERT_NE(std::tolower('I'), 'i');
  EXPECT_EQ(parseRepresentations("NAIVE", autoFrameLevel)[0].label(), "NAIVE");
  EXPECT_EQ(parseRepresentations("cGRID", autoFrameLevel)[0].label(), "cGRID");
}

TEST(Representation, ListsContainTheLibrarysKinds) {
  EXPECT_EQ(listOfRepresentations(",", " or "),
            "naive,naive-compact,grid,cgrid,cvoxel,cleaf,cleaf-only,cvert or ctile");
  EXPECT_EQ(defaultRepresentations(), "naive,naive-compact,grid,cgrid,cvoxel,cleaf,cvert,ctile");
  const auto list = parseRepresentations(listOfRepresentations(","), autoFrameLevel);
  const std::vector<RTCCompression> compressions = {
      RTC_COMPRESSION_NONE,  RTC_COMPRESSION_NONE,   RTC_COMPRESSION_NONE,
      RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
      RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT,  RTC_COMPRESSION_CTILE};
  const std::vector<std::string> labels = {"NAIVE", "NAIVE-compact", "GRID",  "cGRID", "cVOXEL",
                                           "cLEAF", "cLEAF-only",    "cVERT", "cTILE"};
  ASSERT_EQ(list.size(), labels.size());
  for (size_t i = 0; i < list.size(); i++) {
    SCOPED_TRACE(labels[i]);
    EXPECT_EQ(list[i].kind, representationKinds()[i]);
    EXPECT_EQ(list[i].compression(), compressions[i]);
    EXPECT_EQ(list[i].isCompressed(), i > 2);
    EXPECT_EQ(list[i].isTriangulated(), i < 2);
    EXPECT_EQ(list[i].hasFrames(), i > 2 && i < 7);
    EXPECT_EQ(list[i].label(), labels[i]);
  }
  EXPECT_EQ(list.back().deviceConfig(), "subdiv_accel=cbvh.tile");
}

TEST(Representation, CompactTrianglesDifferByAFlagOfTheScene) {
  const auto list = parseRepresentations("Naive,NAIVE-compact,grid", 2);
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[1].kind, RepresentationKind::NaiveCompact);
  EXPECT_EQ(list[1].fileStem(), "naive-compact");
  EXPECT_EQ(list[1].deviceConfig(), list[0].deviceConfig());
  EXPECT_EQ(list[0].sceneFlags(), RTC_SCENE_FLAG_NONE);
  EXPECT_EQ(list[1].sceneFlags(), RTC_SCENE_FLAG_COMPACT);
  EXPECT_EQ(list[2].sceneFlags(), RTC_SCENE_FLAG_NONE);
  EXPECT_EQ(meshRepresentations(), "grid,naive-compact,cvert,ctile");
}

// The programs' labels name what the user asked for. The library stores other blocks, or none, if the surface moves.
TEST(Representation, NamesWhatReplacesItInMotion) {
  Model model;
  const auto all = parseRepresentations(listOfRepresentations(",") + ",cgrid^2", autoFrameLevel);
  EXPECT_EQ(motionWarnings(model, all), "") << "a static model";
  model.poses.resize(1);
  const std::string warnings = motionWarnings(model, all);
  EXPECT_TRUE(containsInOrder(
      warnings, {"cgrid ", "cVERT", "\ncvoxel ", "cVERT", "\ncleaf ", "cVERT", "\ncleaf-only ", "GRID", "\n"}));
  EXPECT_EQ(std::count(warnings.begin(), warnings.end(), '\n'), 4) << warnings;
  EXPECT_EQ(motionWarnings(model, parseRepresentations("naive,naive-compact,grid,cvert,ctile", autoFrameLevel)), "");
}

TEST(Representation, FrameLevelsAreLimitedLikeTheLibrarys) {
  EXPECT_EQ(levelRange(), "0 to 8");
  EXPECT_EQ(parseFrameLevel("8"), 8);
  EXPECT_THROW(parseFrameLevel("9"), Error);
}

TEST(Representation, RejectsUnknownNames) {
  for (const char* list : {"", "grid,", "mesh", "grid^2", "naive-compact^2", "compact", "cleaf^9", "cleaf^-1", "cleaf^",
                           "cleaf^2x", "cleaf,cleaf^2"})
    EXPECT_THROW(parseRepresentations(list, 2), Error) << list;
  EXPECT_NO_THROW(parseRepresentations("cleaf,cleaf^3", 2));
}

}} // namespace programs::test
