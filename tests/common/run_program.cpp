// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/run_program.h"
#include "basics/error.h"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace cbvh::test {
namespace {

/* Returns the exit status and the output to stderr. */
std::pair<int, std::string> outcome(const std::function<int()>& run)
{
  testing::internal::CaptureStderr();
  const int status = runProgram("cbvh_test", run);
  return {status, testing::internal::GetCapturedStderr()};
}

TEST(RunProgram, ReturnsTheStatus)
{
  EXPECT_EQ(outcome([] { return 0; }), std::make_pair(0, std::string()));
  EXPECT_EQ(outcome([] { return 3; }), std::make_pair(3, std::string()));
}

TEST(RunProgram, PrintsExceptionsInOneLine)
{
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

} // namespace
} // namespace cbvh::test
