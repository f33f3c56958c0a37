// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/progress.h"
#include "basics/error.h"
#include "basics/file_output.h"
#include "basics/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace programs::test { namespace {

/* Handlers and flags belong to the process: code that sets them runs in its own process. */

void loopUntilCancelled() {
  installCancelHandler();
  std::atomic<size_t> calls{0};
  try {
    parallelFor(SIZE_MAX, 1, 2, [&](size_t, size_t) {
      if (calls++ == 1000) std::raise(SIGINT);
    });
  } catch (const Canceled&) {
    std::fputs("stopped by itself", stderr);
    std::_Exit(7);
  }
}

TEST(CancelDeathTest, SignalEndsLoops) {
  EXPECT_EXIT(loopUntilCancelled(), testing::ExitedWithCode(7), "stopped by itself");
}

/* Like code that does not check the flag. */
void hang(const std::string& path) {
  installCancelHandler();
  forceExitAfterCancel("test");
  PendingFile file(path);
  std::ofstream(file.temporary()) << "half of a";
  std::raise(SIGINT);
  for (;;) pause();
}

TEST(CancelDeathTest, HangingProcessIsEndedAndItsFileRemoved) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("cbvh_progress_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  EXPECT_EXIT(hang((folder / "file.txt").string()), testing::ExitedWithCode(130), "test: cancel+ed");
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove_all(folder);
}

}} // namespace programs::test
