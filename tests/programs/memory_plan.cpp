// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "memory_plan.h"
#include "basics/error.h"
#include "building/memory.h"
#include "support/message_parts.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace programs::test { namespace {

constexpr size_t quads = 1000000;

std::string builtOf(const MemoryPlan& plan) {
  std::string list;
  for (const Representation& r : plan.built) list += (list.empty() ? "" : ",") + r.fileStem();
  return list;
}

MemoryPlan plan(const std::string& asked, size_t available) {
  return planMemory(parseRepresentations(asked, 2), quads, available);
}

size_t peak(RepresentationKind kind) { return estimatedPeakBytes(kind, quads); }

TEST(MemoryPlan, EverythingThatFitsIsBuiltGridFirst) {
  const MemoryPlan all = plan("cleaf,naive,grid,cvert", SIZE_MAX);
  EXPECT_EQ(builtOf(all), "grid,naive,cleaf2,cvert");
  EXPECT_TRUE(all.skipped.empty());
  EXPECT_EQ(builtOf(plan("cleaf,naive-compact,naive,grid", SIZE_MAX)), "grid,naive,naive-compact,cleaf2");
  EXPECT_EQ(builtOf(plan("cleaf", SIZE_MAX)), "cleaf2") << "only requested representations are built";
}

TEST(MemoryPlan, ReferencesAreLeftOutBeforeCompressedOnes) {
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
  EXPECT_TRUE(containsInOrder(alone.skipped[0], {"GRID ", "1.0 million quads"}));
  EXPECT_EQ(alone.skipped[1].rfind("NAIVE ", 0), 0u) << alone.skipped[1];
}

TEST(MemoryPlan, CompressedRepresentationThatDoesNotFitIsLeftOut) {
  EXPECT_EQ(builtOf(plan("cgrid,cleaf", peak(RepresentationKind::CGrid) - 1)), "cleaf2");
}

TEST(MemoryPlan, TimeStepsRequireMoreMemory) {
  for (RepresentationKind kind : {RepresentationKind::Naive, RepresentationKind::NaiveCompact, RepresentationKind::Grid,
                                  RepresentationKind::CGrid, RepresentationKind::CLeaf, RepresentationKind::CVert})
    EXPECT_LT(estimatedPeakBytes(kind, {quads, 2}), estimatedPeakBytes(kind, {quads, 3})) << int(kind);
  EXPECT_EQ(estimatedPeakBytes(RepresentationKind::CGrid, {quads, 2}),
            estimatedPeakBytes(RepresentationKind::CVert, {quads, 2}))
      << "moving surfaces use cVERT";
  const std::vector<Representation> asked = parseRepresentations("grid,cvert", 2);
  const size_t still = peak(RepresentationKind::Grid) + peak(RepresentationKind::CVert);
  EXPECT_EQ(builtOf(planMemory(asked, {quads, 1}, still)), "grid,cvert");
  EXPECT_EQ(builtOf(planMemory(asked, {quads, 2}, still)), "cvert");
}

TEST(MemoryPlan, NoRepresentationThatFitsIsAnError) { EXPECT_THROW(plan("grid,cleaf", 1000), Error); }

/* A folder with the files from which Linux's memory is read. */
class AvailableMemory : public testing::Test {
protected:
  void SetUp() override { write("proc/meminfo", "MemTotal: 9000 kB\nMemAvailable:    4000 kB\n"); }
  ~AvailableMemory() override { std::filesystem::remove_all(root); }

  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((root / name).parent_path());
    std::ofstream(root / name) << text;
  }

  void writeGroup(const std::string& path, const std::string& limit, const std::string& used) const {
    write("sys/fs/cgroup" + path + "/memory.max", limit + "\n");
    write("sys/fs/cgroup" + path + "/memory.current", used + "\n");
  }

  size_t kibibytes() const { return availableMemory(root.string()) / 1024; }

  const std::filesystem::path root =
      std::filesystem::temp_directory_path() / ("cbvh-memory-" + std::to_string(getpid()));
};

TEST_F(AvailableMemory, WithoutALimitIsReadFromMeminfo) {
  EXPECT_EQ(kibibytes(), 4000u);
  write("proc/self/cgroup", "0::/\n");
  writeGroup("", "max", "1024");
  EXPECT_EQ(kibibytes(), 4000u);
  std::filesystem::remove(root / "proc/meminfo");
  EXPECT_EQ(availableMemory(root.string()), SIZE_MAX);
}

TEST_F(AvailableMemory, CachedFilesOfAGroupCanBeFreed) {
  write("proc/self/cgroup", "0::/\n");
  writeGroup("", "3072000", "2048000");
  EXPECT_EQ(kibibytes(), 1000u);
  write("sys/fs/cgroup/memory.stat", "anon 512000\nfile 1536000\ninactive_file 1024000\nactive_file 512000\n");
  EXPECT_EQ(kibibytes(), 2500u);
  write("sys/fs/cgroup/memory.current", "4096000\n");
  EXPECT_EQ(kibibytes(), 500u);
  write("sys/fs/cgroup/memory.max", "1024000\n");
  EXPECT_EQ(kibibytes(), 0u);
}

TEST_F(AvailableMemory, IsLimitedByEachEnclosingGroup) {
  write("proc/self/cgroup", "1:name=systemd:/elsewhere\n0::/jobs/mine\n");
  writeGroup("/jobs", "1024000", "0");
  writeGroup("/jobs/mine", "2048000", "0");
  EXPECT_EQ(kibibytes(), 1000u);
  write("sys/fs/cgroup/jobs/mine/memory.max", "512000\n");
  EXPECT_EQ(kibibytes(), 500u);
}

TEST_F(AvailableMemory, IsLimitedByGroupsOfVersion1) {
  write("proc/self/cgroup", "4:memory:/host/path\n0::/\n"); // the path outside of a container
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "2048000\n");
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", "1024000\n");
  write("sys/fs/cgroup/memory/memory.stat", "inactive_file 0\ntotal_inactive_file 512000\n");
  EXPECT_EQ(kibibytes(), 1500u);
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(kibibytes(), 4000u);
}

}} // namespace programs::test
