// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/run_program.h"
#include "basics/error.h"
#include "basics/file_output.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <unistd.h>

namespace programs::test { namespace {

/* Returns the exit status and the output to stderr. */
std::pair<int, std::string> outcome(const std::function<int()>& run) {
  testing::internal::CaptureStderr();
  const int status = runProgram("cbvh_test", run);
  return {status, testing::internal::GetCapturedStderr()};
}

TEST(RunProgram, ReturnsTheStatus) {
  EXPECT_EQ(outcome([] { return 0; }), std::make_pair(0, std::string()));
  EXPECT_EQ(outcome([] { return 3; }), std::make_pair(3, std::string()));
}

TEST(RunProgram, PrintsExceptionsInOneLine) {
  const std::pair<int, std::string> canceled = outcome([]() -> int { throw Canceled(); });
  EXPECT_EQ(canceled.first, 130);
  EXPECT_EQ(canceled.second.find("cbvh_test: cancel"), 0u) << canceled.second;
  EXPECT_EQ(canceled.second.find('\n'), canceled.second.size() - 1) << canceled.second;
  const std::pair<int, std::string> exhausted = outcome([]() -> int { throw std::bad_alloc(); });
  EXPECT_EQ(exhausted.first, 1);
  EXPECT_EQ(exhausted.second.find("cbvh_test: "), 0u) << exhausted.second;
  EXPECT_NE(exhausted.second.find("memory"), std::string::npos) << exhausted.second;
  EXPECT_EQ(exhausted.second.find('\n'), exhausted.second.size() - 1) << exhausted.second;
  EXPECT_EQ(outcome([]() -> int { throw Error("x.obj: 100% wrong"); }),
            std::make_pair(1, std::string("cbvh_test: x.obj: 100% wrong\n")));
  EXPECT_EQ(outcome([]() -> int { throw std::out_of_range("far"); }),
            std::make_pair(1, std::string("cbvh_test: far\n")));
}

TEST(RunProgram, RemovesEmptyOutputFoldersAfterFailures) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("cbvh_run_program_" + std::to_string(::getpid()));
  const fs::path existing = folder / "existing", created = existing / "a" / "b";
  fs::create_directories(existing);
  const auto run = [&](const std::function<int()>& end) {
    return outcome([&] {
             prepareOutputFolder(existing.string());
             prepareOutputFolder(created.string());
             return end();
           })
        .first;
  };
  EXPECT_EQ(run([]() -> int { throw Error("no such file"); }), 1);
  EXPECT_TRUE(fs::is_empty(existing)) << "the folder and its parent are removed";
  EXPECT_EQ(run([]() -> int { throw Canceled(); }), 130);
  EXPECT_TRUE(fs::is_empty(existing));
  const auto write = [&] { std::ofstream(created.parent_path() / "picture.png") << "bytes"; };
  EXPECT_EQ(run([&]() -> int {
              write();
              throw Error("later");
            }),
            1);
  EXPECT_TRUE(fs::exists(created.parent_path() / "picture.png"));
  EXPECT_FALSE(fs::exists(created));
  fs::remove_all(existing / "a");
  EXPECT_EQ(run([] { return 0; }), 0);
  EXPECT_TRUE(fs::exists(created)) << "success keeps folders";
  fs::remove_all(folder);
}

}} // namespace programs::test
