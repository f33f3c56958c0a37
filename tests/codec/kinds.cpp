// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The table of kinds, and references of flat scenes, which depend on it. */

#include "kernels/cbvh/base/reference.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace programs::test { namespace {

using namespace embree::cbvh;

TEST(Kinds, NumbersOfBlocksAndApiAreFixed) {
  const struct {
    Kind kind;
    uint32_t number;
    int compression;
    const char *key, *name;
    bool hasFrame;
  } expected[] = {
      {Kind::CGRID, 0, 2, "grid", "cGRID", true},  {Kind::CVOXEL, 1, 3, "voxel", "cVOXEL", true},
      {Kind::CLEAF, 2, 4, "leaf", "cLEAF", true},  {Kind::CVERT, 3, 5, "vert", "cVERT", false},
      {Kind::CTILE, 4, 6, "tile", "cTILE", false},
  };
  ASSERT_EQ(std::size(expected), numKinds);
  for (const auto& e : expected) {
    SCOPED_TRACE(e.name);
    const KindDescription& row = descriptionOf(e.kind);
    EXPECT_EQ(uint32_t(row.kind), e.number);
    EXPECT_EQ(int(row.compression()), e.compression);
    EXPECT_STREQ(row.key, e.key);
    EXPECT_STREQ(row.name, e.name);
    EXPECT_EQ(row.hasFrame(), e.hasFrame);
    Kind found = Kind::CGRID;
    EXPECT_TRUE(findKind(e.compression, found));
    EXPECT_EQ(found, e.kind);
  }
  for (uint32_t compression = RTC_COMPRESSION_CGRID; compression <= RTC_COMPRESSION_CVERT; compression++)
    EXPECT_EQ(uint32_t(compressionOfLoaded(compression)), compression);
  Kind none = Kind::CGRID;
  for (int compression : {-1, 0, 1, 7, 100}) EXPECT_FALSE(findKind(compression, none)) << compression;
}

// Including reserved numbers, each with the smallest and the largest index.
TEST(References, EachReferenceHasOneType) {
  std::set<uint32_t> references = {emptyReference};
  size_t count = 1;
  const uint32_t indices[] = {0, 1, 12345678, (1u << 27) - 1};
  const auto add = [&](uint32_t reference, uint32_t type, uint32_t index) {
    EXPECT_EQ(referenceType(reference), type);
    EXPECT_EQ(referenceIndex(reference), index);
    references.insert(reference);
    count++;
  };
  for (uint32_t index : indices) {
    for (uint32_t type : {nodeReferenceType, gridLeafReferenceType, instanceReferenceType})
      add(makeReference(type, index), type, index);
    for (uint32_t kind = 0; kind < numKinds + 14; kind++) {
      add(makeReference(blockReferenceType(kind), index), blockReferenceType(kind), index);
      EXPECT_FALSE(isRunType(blockReferenceType(kind)));
    }
    for (uint32_t triangles = 1; triangles <= 4; triangles++) {
      const uint32_t reference = makeRunReference(index, triangles), type = referenceType(reference);
      EXPECT_TRUE(isRunType(type));
      EXPECT_EQ(runLength(type), triangles);
      add(reference, type, index);
    }
  }
  EXPECT_EQ(references.size(), count);
  for (uint32_t type : {nodeReferenceType, gridLeafReferenceType, instanceReferenceType, referenceType(emptyReference)})
    EXPECT_FALSE(isRunType(type));
}

}} // namespace programs::test
